"""The tests that `make quick` chooses: those nearest to the changed files, each with its reason."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tools import quick


def names(*paths):
    return [test for test, _ in quick.chosen(list(paths))]


def test_who_imports_what_changed_comes_before_who_imports_it_at_second_hand():
    tests = dict(quick.chosen(["queueing/fairshare.py"]))
    first, *others = tests
    assert first == "tests/unit/test_fairshare.py"
    assert tests[first] == "queueing.fairshare < tests.unit.test_fairshare"
    assert tests["tests/services/test_queue.py"].count(" < ") > 1
    assert "tests/unit/test_scara.py" not in others, "it has nothing to do with it"


@pytest.mark.parametrize(
    ("path", "test"),
    [
        ("tests/unit/test_scara.py", "tests/unit/test_scara.py"),
        ("tests/faults/test_hub.py", "tests/faults/test_hub.py"),  # real processes, but asked for
        ("tests/vectors/waits.json", "tests/unit/test_wait_words.py"),
        ("templates/pages/statistics.html", "tests/services/test_statistics.py"),
        ("docs/reference/settings.md", "tests/unit/test_settings_page.py"),
        ("frontend/src/page/console.ts", "tests/unit/test_consoles.py"),
        ("robots/kit/drivers/mercury/model.urdf", "tests/unit/test_scara.py"),
        ("queueing/admin.py", "tests/services/test_admin_rights.py"),  # by address alone
        ("portal/web/pages/views.py", "tests/services/test_pages.py"),
    ],
)
def test_each_kind_of_file_has_its_tests(path, test):
    assert test in names(path)


def test_a_conftest_asks_for_all_of_its_folder():
    folder = quick.ROOT / "tests/security"
    tests = {str(file.relative_to(quick.ROOT)) for file in folder.glob("test_*.py")}
    assert dict(quick.chosen(["tests/security/conftest.py"])) == dict.fromkeys(
        tests, "in the folder of tests/security/conftest.py"
    )


def test_what_no_test_imports_takes_those_of_its_folder():
    found = dict(quick.chosen(["queueing/not_there.py"]))
    assert "for queueing/not_there.py" in found["tests/unit/test_fairshare.py"]


def test_those_with_real_processes_are_for_the_gate():
    assert [test for test in names("robots/models") if test.startswith(quick.OTHERS)] == []


def test_a_changed_test_with_real_processes_comes_after_a_changed_one_without():
    assert names("tests/faults/test_hub.py", "tests/unit/test_scara.py")[0] == "tests/unit/test_scara.py"


def test_what_is_named_by_hand_is_there():
    assert [name for name in (*quick.EVERY, *quick.OTHERS) if not (quick.ROOT / name).exists()] == []
    assert {path.split("/")[0] for path in names("robots/kit/clock.py")} == {"tests"}


@pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed")
def test_changes_are_those_since_the_branch_left_main(tmp_path):
    def git(*words):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@example.org", *words], cwd=tmp_path, check=True)

    def write(**texts):
        for name, text in texts.items():
            Path(tmp_path / name).write_text(text)

    git("init", "-q", "-b", "main")
    write(old="1", gone="1", kept="1", uncommitted="1", staged="1")
    git("add", ".")
    git("commit", "-qm", "first")
    git("checkout", "-qb", "branch")
    write(old="2")
    git("commit", "-qam", "second")
    git("checkout", "-q", "main")
    write(kept="2")
    git("commit", "-qam", "not of this branch")
    git("checkout", "-q", "branch")
    (tmp_path / "gone").unlink()
    write(uncommitted="2", staged="2", new="1")
    git("add", "staged")
    assert quick.changed(tmp_path) == ["gone", "new", "old", "staged", "uncommitted"]


@pytest.mark.parametrize(("left_s", "runs"), [(1e6, True), (-1.0, False)])
def test_what_has_not_begun_in_time_is_left_out(monkeypatch, left_s, runs):
    monkeypatch.setenv(quick.END, str(quick.time.monotonic() + left_s))
    try:
        quick.pytest_runtest_setup()
    except pytest.skip.Exception:
        assert not runs
    else:
        assert runs
