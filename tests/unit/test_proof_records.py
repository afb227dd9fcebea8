"""The notes beside a figure of a proof: whose time, commit, pace and discarded samples; and when it is outdated."""

import json
import shutil
import subprocess

import pytest

from tests import history, outdated, pace, proofs
from tests.proof import REAL, VIRTUAL, Proof


class Node:
    """A test, as pytest tells of it."""

    def __init__(self, room, *marks):
        self.path, self.name = proofs.ROOT / "tests" / room / "test_a.py", "test_promise_07_stops[irat]"
        self._marks = marks

    def get_closest_marker(self, name):
        return name if name in self._marks else None


@pytest.mark.parametrize(
    ("node", "time"),
    [
        (Node("services"), VIRTUAL), (Node("world", "service"), VIRTUAL),
        (Node("services", "timed"), REAL), (Node("faults"), REAL),
    ],
)  # fmt: skip
def test_a_record_tells_whose_time_passed_and_how_the_machine_was(tmp_path, node, time):
    paces = iter([{"work": 1.0, "sleep": 1.1}, {"work": 3.0, "sleep": 1.2}])
    proof = Proof.at(node, kept=tmp_path, measured=lambda: next(paces))
    proof.count("stops", 2, 30)
    proof.discards(3, "the machine stalled")
    proof.discards(0, "it was at rest already")
    proof.holds("at rest")
    line = json.loads((tmp_path / "proofs.jsonl").read_text())
    assert (line["promise"], line["test"], line["time"]) == (7, "test_a.py::test_promise_07_stops[irat]", time)
    assert line["discarded"] == [{"number": 3, "why": "the machine stalled"}]
    measured = {"before": {"work": 1.0, "sleep": 1.1}, "after": {"work": 3.0, "sleep": 1.2}}
    assert line["pace"] == (measured if time == REAL else {"before": {}, "after": {}})


@pytest.fixture
def page(tmp_path, monkeypatch):
    """A list and a page of proofs of their own; returns what reads the page."""
    monkeypatch.setattr(proofs, "KEPT", tmp_path / "proofs.json")
    monkeypatch.setattr(proofs, "PAGE", tmp_path / "proofs.md")
    return proofs.PAGE.read_text


def run_with_seeds(folder, *seeds):
    """Two kills each; a seed's number is how late it was."""
    folder.mkdir()
    for seed in seeds:
        proof = Proof(f"test_a.py::test_promise_02_kills[seed{seed}-irat]", 2, seeds=3, kept=folder)
        proof.count("kills", 2, 2)
        proof.holds(f"{seed} s late", seed)


def test_all_seeds_of_a_test_are_one_figure_and_it_is_missing_until_each_was_run(tmp_path, page):
    name = "tests/world/test_a.py::test_promise_02_kills[seed{}-irat]"
    wanted = {name.format(seed): 2 for seed in (1, 2, 3)}
    run_with_seeds(tmp_path / "one", 2, 1)
    proofs.take(tmp_path / "one", "abc1234")
    assert [(r["test"], r["figure"]) for r in proofs.kept()] == [("test_a.py::test_promise_02_kills[irat]", "2 s late")]
    kept = [r | {"full": True} for r in proofs.kept()]
    assert proofs.missing(wanted, kept, "") == {(2, "sqlite"): list(wanted)}
    run_with_seeds(tmp_path / "two", 3)
    proofs.take(tmp_path / "two", "abc1234")
    proofs.write()
    assert "| worst seed: 3 s late | 3 / 3 seeds; 6 / 6 kills | virtual time; commit abc1234; 0 discarded |" in page()
    kept = [r | {"full": True} for r in proofs.kept()]
    assert proofs.missing(wanted, kept, "") == {}
    run_with_seeds(tmp_path / "three", 1)
    proofs.take(tmp_path / "three", "def5678")
    assert proofs.kept()[0]["figure"] == "1 s late", "of a newer commit"


def test_the_pace_is_a_ratio_to_nominal(clock):
    assert pace.measured(clock) == {"work": 0.0, "sleep": 1.0}, "by a clock that counts sleeps alone"


def record(**more):
    return {"promise": 7, "test": "a", "database": "sqlite", "figure": "f", "counts": [], **more}


def test_the_page_tells_how_each_figure_was_measured_and_of_older_ones_that_nobody_knows():
    assert proofs.how(record()) == "not recorded"
    told = proofs.how(record(
        time="real", commit="abc1234+changes", discarded=[{"number": 3, "why": "the machine stalled"}],
        pace={"before": {"work": 1.04, "sleep": 1.1}, "after": {"work": 3.0, "sleep": 1.2}},
    ))  # fmt: skip
    assert told == (
        "real time; commit abc1234+changes; pace before work 1.0, sleep 1.1, after work 3.0, sleep 1.2; "
        "3 discarded: the machine stalled"
    )
    assert proofs.how(record(time="virtual", commit="", pace={}, discarded=[])) == (
        "virtual time; commit not recorded; 0 discarded"
    )


def test_every_record_that_is_kept_can_be_read():
    assert all(proofs.how(r) for r in proofs.kept())


@pytest.fixture
def tree(tmp_path):
    """A folder with a history of one commit; returns what runs git in it."""

    if shutil.which("git") is None:
        pytest.skip("git is not installed")

    def git(*words):
        command = ["git", "-c", "user.name=a", "-c", "user.email=a@example.org", *words]
        return subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True).stdout.strip()

    git("init", "-q", "-b", "main")
    (tmp_path / "robots").mkdir()
    for name in ("robots/a.py", "robots/b.py", "page.md"):
        (tmp_path / name).write_text("1")
    git("add", ".")
    git("commit", "-qm", "first")
    return git


def test_a_commit_is_named_with_whether_the_tree_differs(tree, tmp_path):
    short = history.commit(tmp_path)
    assert tree("rev-parse", "HEAD").startswith(short)
    assert short
    (tmp_path / "page.md").write_text("2")
    assert history.commit(tmp_path, ["page.md"]) == short, "the page of the proofs itself"
    assert history.commit(tmp_path) == f"{short}+changes"


def test_what_changed_since_is_told_committed_or_not(tree, tmp_path):
    short = history.commit(tmp_path)
    assert history.changed(tmp_path, short, ["robots"]) == []
    (tmp_path / "robots/a.py").write_text("2")
    tree("commit", "-qam", "second")
    (tmp_path / "robots/b.py").write_text("2")
    (tmp_path / "page.md").write_text("2")
    assert history.changed(tmp_path, short, ["robots"]) == ["robots/a.py", "robots/b.py"]


def test_without_a_history_nothing_is_told(tree, tmp_path, monkeypatch):
    with pytest.raises(history.NoHistory, match="commit abcdef1 is not in this history"):
        history.changed(tmp_path, "abcdef1", ["robots"])
    monkeypatch.setenv("PATH", "")
    with pytest.raises(history.NoHistory, match="git is not installed"):
        history.changed(tmp_path, "abcdef1", ["robots"])
    assert history.commit(tmp_path) == ""


def test_each_promise_of_which_something_changed_has_a_warning():
    def differs(since, paths):
        if since == "gone":
            raise history.NoHistory("commit gone is not in this history")
        return [path for path in paths if path != "same.py"] if since == "old" else []

    records = [
        record(commit="old"), record(promise=1, commit="new"), record(promise=2, commit="old"),
        record(promise=3, commit="gone"), record(promise=4), record(promise=5, commit=""), record(promise=6, commit="new+changes"),
    ]  # fmt: skip
    paths = {7: ["a.py", "b.py", "c.py", "d.py"], 1: ["a.py"], 2: ["same.py"], 3: ["a.py"], 6: ["a.py"]}
    assert outdated.warnings(records, paths, differs) == [
        "promise 7 was measured before changes of a.py, b.py, c.py and 1 more: make proofs P=7",
        "cannot tell of promises 3: commit gone is not in this history",
        "cannot tell of promises 4, 5: their figures name no commit",
        "cannot tell of promises 6: measured at new with changes that are in no commit",
    ]


def test_the_table_of_what_promises_rest_on_is_whole():
    table = outdated.covered()
    with_figures = {r["promise"] for r in proofs.kept()}
    assert with_figures | set(proofs.OF_SECONDS) <= set(table) <= set(proofs.PROMISES)
    assert {path for paths in table.values() for path in paths if not (proofs.ROOT / path).exists()} == set()
