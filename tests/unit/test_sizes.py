"""Files stay short enough to be read: none over 400 lines, nine of ten under 250, half of ours under 90."""

from statistics import median, quantiles

from tests.environment import ROOT

ROOMS = ("accounts", "operatorlog", "portal", "queueing", "robots", "simulators", "workers")
BESIDE = ("benchmarks", "frontend/src", "frontend/tests", "tests", "tools")


def lines(rooms):
    """Return how many lines each Python and TypeScript file of ours has."""
    found = [file for room in rooms for end in ("py", "ts") for file in (ROOT / room).rglob(f"*.{end}")]
    written = [file for file in found if not {"migrations", "node_modules"} & set(file.parts)]
    return {str(file.relative_to(ROOT)): len(file.read_text().splitlines()) for file in written}


def test_no_file_is_long():
    assert {name: long for name, long in lines(ROOMS + BESIDE).items() if long > 400} == {}


def test_most_files_are_short():
    sizes = [long for long in lines(ROOMS).values() if long]
    assert median(sizes) < 100
    assert quantiles(sizes, n=10)[-1] < 250
