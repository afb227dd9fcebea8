"""A plugin of pytest that notes what failed: `-p tests.failed --failed-to FILE`, one test a line of JSON."""

import json
from pathlib import Path


def pytest_addoption(parser):
    parser.addoption("--failed-to", type=Path, help="write the tests that failed to this file, a line of JSON each")


def pytest_configure(config):
    path = config.getoption("failed_to")
    if path is not None and not hasattr(config, "workerinput"):  # the workers of xdist report to it
        config.pluginmanager.register(Noted(path))


class Noted:
    """Writes each failure at once, so that a run that is cut off has told what it knew."""

    def __init__(self, path: Path):
        self._path = path

    def _note(self, test: str, said: str) -> None:
        with self._path.open("a") as out:
            out.write(json.dumps({"test": test, "said": said}) + "\n")

    def pytest_runtest_logreport(self, report):
        if report.failed:
            crash = getattr(report.longrepr, "reprcrash", None)
            self._note(report.nodeid, crash.message if crash else str(report.longrepr))

    def pytest_collectreport(self, report):
        if report.failed:
            self._note(report.nodeid, "it cannot be read")

    def pytest_internalerror(self, excrepr):
        self._note("", str(excrepr)[-500:])
