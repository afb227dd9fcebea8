"""`make quick`: for 25 s, run the tests nearest to the files changed since main's merge base, uncommitted ones too.

The nearest tests have the fewest imports between them and a changed file. The tool prints which tests it chose and why,
and counts the others; `make test` runs all.
"""

import os
import re
import subprocess
import sys
import time
from pathlib import Path
from zlib import crc32

import grimp
import pytest

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ("accounts", "benchmarks", "operatorlog", "portal", "queueing", "robots", "simulators", "tests", "tools", "workers")  # fmt: skip
LIMIT, SECONDS, END = 24, 25.0, "FARHAND_QUICK_END"  # files at most; a test that has not begun by then is skipped
EVERY = ["tests/unit/test_generic_words.py", "tests/unit/test_sizes.py"]  # they judge the text of every file
OTHERS = ("tests/drivers/", "tests/e2e/", "tests/faults/", "tests/services/test_movies_arrive.py")  # take long
WEB = re.compile(r"\b(client|admin|Client)\b")  # asks for pages, so it uses what answers by address alone
RULES = (  # files to which no import leads, and the modules that stand for them
    (re.compile(r"templates/"), "portal.urls"),
    (re.compile(r"frontend/"), "portal.web.consoles.console"),
    (re.compile(r"(robots/kit/drivers|simulators)/(\w+)/"), r"\1.\2"),
    (re.compile(r"pyproject\.toml|Makefile|requirements/|\.ci/"), "tools.setup"),
)
Found = dict[str, tuple[int, str]]  # of each test: how many imports lie between, and why it was chosen


def changed(root: Path = ROOT) -> list[str]:
    """Return the files that differ from the commit at which this branch left main, also deleted ones."""

    def git(*words: str, check: bool = True) -> list[str]:
        return subprocess.run(["git", *words], cwd=root, check=check, stdout=-1, text=True).stdout.splitlines()

    since = [*git("merge-base", "HEAD", "main", check=False), "HEAD"][0]
    return sorted({*git("diff", "--name-only", since), *git("ls-files", "--others", "--exclude-standard")})


def graph_of_imports(tests: dict[str, str]) -> grimp.ImportGraph:
    """Return the graph of imports without `tests.conftest`, which connects every test with every module."""
    graph = grimp.build_graph(*ROOMS, cache_dir=None)
    graph.remove_module("tests.conftest")
    for test, text in tests.items():
        if test.startswith(("tests/services/", "tests/security/")) and WEB.search(text):
            graph.add_import(importer=module_of(test), imported="portal.urls")
    for module in graph.find_matching_modules("*.admin"):
        graph.add_import(importer="portal.urls", imported=module)
    return graph


def module_of(path: str) -> str:
    """Return the module of a file."""
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def importers(graph: grimp.ImportGraph, begin: set[str], tests: dict[str, str]) -> Found:
    """Return the tests that import one of these modules, at first or second hand."""
    ways = {module: [module] for module in sorted(begin & graph.modules)}
    for module in (queue := list(ways)):  # which grows: the nearest first
        for other in sorted(graph.find_modules_that_directly_import(module) - ways.keys()):
            ways[other] = [*ways[module], other]
            queue.append(other)
    return {t: (len(way) - 1, " < ".join(way)) for t in tests if (way := ways.get(module_of(t)))}


def tests_of(path: str, graph: grimp.ImportGraph, tests: dict[str, str]) -> Found:
    """Return the tests of a changed file; if no import leads from it to a test, those of its folder."""
    folder, _, name = path.rpartition("/")
    if name == "conftest.py":
        return {test: (1, f"in the folder of {path}") for test in tests if test.startswith(f"{folder}/")}
    if path.endswith(".py") and (found := importers(graph, {module_of(path)}, tests)):
        return found
    spelt = re.compile(rf"(?<![\w.]){re.escape(name)}\b")
    rooms = [rule.match(path).expand(to).replace("/", ".") for rule, to in RULES if rule.match(path)]  # type: ignore
    rooms = rooms or [folder.replace("/", ".")] * path.endswith(".py")
    inside = {module for module in graph.modules for room in rooms if f"{module}.".startswith(f"{room}.")}
    near = importers(graph, inside, tests).items()
    named = {test: (1, f"names {path}") for test, text in tests.items() if spelt.search(text)}
    return {test: (n + 2, f"{way}, for {path}") for test, (n, way) in near} | named


def chosen(paths: list[str]) -> list[tuple[str, str]]:
    """Return all tests of these files, each with the reason, the nearest first."""
    tests = {str(file.relative_to(ROOT)): file.read_text() for file in sorted(ROOT.glob("tests/*/test_*.py"))}
    graph, found = graph_of_imports(tests), {}
    for path in paths:
        for test, why in tests_of(path, graph, tests).items():
            if test in paths or not test.startswith(OTHERS):
                found[test] = min(why, found.get(test, why))
    words = {word for path in paths for word in re.findall(r"[a-z0-9]+", Path(path).stem)}

    def rank(test: str) -> tuple[int, bool, int, int]:  # equally near: the quick, the names, a fixed mixture
        named = len(words & set(Path(test).stem.split("_")))
        return found[test][0], test.startswith(OTHERS), -named, crc32(test.encode())

    return [(test, found[test][1]) for test in sorted(found, key=rank)]


def pytest_runtest_setup() -> None:
    """Skip a test that has not begun in time; pytest calls this because the file is its plug-in."""
    if time.monotonic() > float(os.environ.get(END, "inf")):
        pytest.skip(f"not begun within {SECONDS:.0f} s: make test")


def main() -> None:
    """Choose, print and run the tests; the command line's arguments go to pytest."""
    paths = changed()
    tests = chosen(paths)
    near = dict(tests[:LIMIT])
    head = f"{len(paths)} files changed; the nearest {len(near)} of {len(tests)} files of tests:"
    told = [f"  {test}: {why}" for test, why in near.items()] + [f"  {test}: reads all files" for test in EVERY]
    sys.stdout.write("\n".join([head, *told, ""]))
    os.environ[END] = str(time.monotonic() + SECONDS)
    sys.exit(pytest.main(["-p", "tools.quick", *sys.argv[1:], *dict.fromkeys([*EVERY, *near])]))


if __name__ == "__main__":
    main()
