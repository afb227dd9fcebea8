"""Compile the map's loops, once after an installation: `python -m robots.kit.drivers.irat.prepare`."""

from robots.kit.slam.slam import compile_loops

if __name__ == "__main__":
    compile_loops()
