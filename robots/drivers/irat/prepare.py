"""Compile the map's loops, once after an installation: `python -m robots.drivers.irat.prepare`."""

from robots.autonomy.ratslam.ready import compile_loops

if __name__ == "__main__":
    compile_loops()
