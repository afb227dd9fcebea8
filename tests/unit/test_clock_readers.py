"""A test that can read a clock is timed, or the collection fails: so none of the gate compares measured seconds."""

from types import ModuleType, SimpleNamespace

import pytest

from tests import clock_readers

RULE = "TID251"  # apart from the word before it, so that this file is none


def module(folder, name, text, **parts):
    file = folder / f"{name}.py"
    file.write_text(text)
    made = ModuleType(name)
    made.__file__ = str(file)
    vars(made).update(parts)
    return made


def item(of, timed):
    return SimpleNamespace(module=of, nodeid=of.__name__, get_closest_marker=lambda name: timed and name == "timed")


@pytest.fixture
def measures(tmp_path):
    return module(tmp_path, "measures", f"# ruff: noqa: {RULE} - its tests are timed\nimport time\n")


@pytest.mark.parametrize(("timed", "found"), [(True, []), (False, ["measures"])])
def test_a_file_that_reads_a_clock_has_timed_tests_alone(measures, timed, found):
    assert clock_readers.in_the_gate([item(measures, timed=timed)]) == found


@pytest.mark.parametrize(("timed", "found"), [(True, []), (False, ["takes"])])
def test_what_such_a_file_measures_is_for_timed_tests_alone(tmp_path, measures, timed, found):
    taken = type("Taken", (), {"__module__": "measures"})
    takes = module(tmp_path, "takes", "from measures import taken\n", taken=taken)
    assert clock_readers.in_the_gate([item(measures, timed=True), item(takes, timed=timed)]) == found


def test_a_line_that_reads_a_clock_counts_too_and_others_may_be_in_the_gate(tmp_path):
    line = module(tmp_path, "line", f"import time  # noqa: {RULE}\n")
    other = module(tmp_path, "other", "import json  # noqa: F401\n")
    assert clock_readers.in_the_gate([item(line, timed=False), item(other, timed=False)]) == ["line"]
