"""The run of the tests: which of those that fail are run once more, and that nothing else turns it green."""

import pytest

from tools import run_tests

PLAIN = "def test_it(): assert 1 == 2"
ONCE = """
from pathlib import Path
def test_it():
    seen = Path(__file__).with_suffix(".seen")
    before = seen.exists()
    seen.touch()
    assert before, "{said}"
"""
SECOND = """
from pathlib import Path
def test_it():
    seen = Path(__file__).with_suffix(".times")
    seen.write_text(seen.read_text() + "x" if seen.exists() else "x")
    assert len(seen.read_text()) == 2, "another answer"
"""
LATE = ONCE.format(said="the picture: not within 5 s")
WRONG = ONCE.format(said="another answer")
BROKEN = "import nothing_of_that_name"


@pytest.fixture
def left(tmp_path, capfd):
    """Return a function that runs such files, and tells what is left as failed and what was run again."""

    (tmp_path / "pytest.ini").write_text("[pytest]")

    def run(*texts, slower=1.0, longest_s=300, **more):
        for number, text in enumerate(texts):
            (tmp_path / f"test_{number}.py").write_text(text)
        runner = run_tests.Runner(slower, longest_s, tmp_path)
        part = run_tests.Part("sqlite", (".",), "not alone", **more)
        failures = runner.again(runner.run((part,), shown=True))
        said = capfd.readouterr().out
        print(said, failures)  # for whoever reads a failure of this test
        return len(failures), said.count("AGAIN, alone")

    return run


@pytest.fixture(autouse=True)
def ordinary(monkeypatch):
    monkeypatch.setattr(run_tests, "pace", lambda: 1.0)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # these files need none


def test_what_waited_in_vain_once_is_run_again(left):
    assert left(LATE, "def test_it(): pass") == (0, 1)


@pytest.mark.parametrize("text", [PLAIN, WRONG, BROKEN])
def test_a_wrong_answer_is_not_run_again(left, text):
    assert left(text) == (1, 0)


def test_a_test_that_hangs_is_ended_and_run_again_like_one_that_waited_in_vain(left, monkeypatch):
    monkeypatch.setenv("PYTEST_PLUGINS", "pytest_timeout")
    assert left("import threading\ndef test_it(): threading.Event().wait()", longest_s=1) == (1, 1)


def test_beside_a_wrong_answer_nothing_else_is_run_again(left):
    assert left(LATE, WRONG) == (2, 0)


def test_what_fails_again_has_failed(left):
    assert left(LATE.replace("before,", "False,")) == (1, 1)


def test_on_a_slow_machine_whatever_failed_is_run_again(left):
    assert left(WRONG, PLAIN, slower=2.0) == (1, 2)


def test_what_failed_in_a_crowd_is_judged_alone(left):
    assert left(WRONG, PLAIN, crowded=True) == (1, 2)


@pytest.mark.parametrize(
    ("text", "failed"), [(WRONG, 0), (PLAIN, 1), (SECOND, 1), (SECOND.replace("another answer", "not within 5 s"), 0)]
)
def test_a_wrong_answer_beside_something_else_has_to_be_right_two_times(left, text, failed):
    assert left(text, twice=True) == (failed, 1)


def test_many_failures_are_not_the_machine_s(left):
    assert left(*[LATE] * 9, slower=2.0) == (9, 0)


def test_a_run_that_ends_without_a_test_s_name_has_failed(left):
    assert left("import os\ndef test_it(): os._exit(3)", slower=2.0) == (1, 0)


@pytest.mark.parametrize(("pace", "workers"), [(0.7, 6), (1.0, 6), (1.5, 4), (2.0, 3), (9.0, 2)])
def test_fewer_files_run_side_by_side_where_the_machine_is_slower(pace, workers):
    argv = run_tests.Part("sqlite", ("tests",), "x", workers=6).argv(pace)
    assert argv[argv.index("-n") + 1] == str(workers)
    assert "-n" not in run_tests.Part("sqlite", ("tests",), "x").argv(pace)
