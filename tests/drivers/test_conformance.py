"""The conformance suite over every driver that is installed here, over the packages of tests, and from the command line."""

import json
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path

import pytest

from robots.conformance.installed import conform_installed
from robots.conformance.report import Verdict
from robots.conformance.suite import CHECKS
from robots.conformance.trial import Limits
from tests.packaged import SHUTTLE, TURNTABLE, installed_from
from tests.rig import PYTHON, ROOT

# how many times faster than real time each simulator runs; the others run in real time
SPEED = {"mercury": 2.0, "pa10": 4.0, "irat": 2.0}
OURS = sorted(file.parent.name for file in (ROOT / "robots/drivers").glob("*/driver.py"))
PATIENT = Limits(answer_s=600.0, watch_s=4.0, beyond_s=600.0)
# what a robot has nothing to show for, of its own spec and simulator
WITHOUT = {
    "mercury": {"replaced", "policies", "streams"},
    "pa10": {"policies", "lanes", "streams"},
    "irat": {"replaced", "policies"},
    "so101": {"held motions", "replaced", "policies", "lanes", "pictures", "streams", "lost power"},
    "turntable": {"held motions", "replaced", "lost line", "lost power", "noise", "pictures"},
    "shuttle": {"held motions", "replaced", "policies", "lanes", "lost line", "lost power", "noise", "streams"},
}


def judged(name):
    speed = SPEED.get(name, 1.0)
    report = conform_installed(name, f"sim:{name}", speed=speed, limits=PATIENT)
    assert not report.failures, report.text()
    assert {r.check for r in report.results if r.verdict == Verdict.NOT_APPLICABLE} <= WITHOUT[name], report.text()
    assert [r.check for r in report.results] == list(CHECKS)


@pytest.mark.parametrize("name", OURS)
def test_every_driver_of_ours_conforms(name):
    if name == "so101" and find_spec("lerobot") is None:
        pytest.skip("LeRobot is an optional extra: make test-lerobot")
    judged(name)


@pytest.mark.gate
@pytest.mark.parametrize("folder", [TURNTABLE, SHUTTLE], ids=lambda folder: folder.name)
def test_the_packages_of_third_parties_conform(folder, monkeypatch):
    monkeypatch.setenv("TURNTABLE_TAKES_S", "0.1")
    with installed_from(folder, monkeypatch):
        judged(folder.name)


def broken(into, file, *changes):
    """Return a folder with the turntable's package in which a file is changed."""
    folder = shutil.copytree(TURNTABLE, into / "broken", ignore=shutil.ignore_patterns("__pycache__"))
    path = folder / "turntable_robot" / file
    text = path.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return folder


def conform(*argv, folder=TURNTABLE):
    """Run the command as a third party does, with the package installed."""
    done = subprocess.run(
        [PYTHON, "manage.py", "conform", *argv], cwd=ROOT, capture_output=True, text=True, check=False,
        env={**_environment(), "PYTHONPATH": str(folder)},
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


def _environment():
    import os

    return {k: v for k, v in os.environ.items() if not k.startswith("FARHAND_TEST")}


@pytest.mark.gate
def test_the_command_tells_a_third_party_that_its_driver_is_in_order(tmp_path):
    file = tmp_path / "report.json"
    code, said, wrong = conform("turntable", "--only", "spec", "--only", "connect", "--json", str(file))
    assert (code, wrong) == (0, "")
    assert "turntable at sim:turntable, a simulator that is started for it." in said
    assert "2 passed, 0 failed, 0 not applicable." in said
    assert [r["verdict"] for r in json.loads(Path(file).read_text())["results"]] == ["passed", "passed"]


@pytest.mark.gate
@pytest.mark.parametrize(
    ("file", "changes", "check", "words"),
    [
        ("driver.py", [('        self._ask(do="hold")\n', "        self.state()\n")], "hold", "returned a state that moves"),
        ("driver.py", [('        check("turntable", kind, args, self.settings)\n', "")], "values", "refuse it with BadRequest"),
        ("spec.py", [('handover=("home",)', 'handover=("rest",)')], "spec", "has no command 'rest', which its handover names"),
        ("spec.py", [("def spec():", "def spec():\n    import turntable_robot.driver")], "spec", "loads turntable_robot.driver"),
    ],
)  # fmt: skip
def test_the_command_names_what_is_broken_and_its_status_is_1(tmp_path, file, changes, check, words):
    code, said, wrong = conform("turntable", "--only", check, folder=broken(tmp_path, file, *changes))
    assert code == 1, said + wrong
    assert words in said
    assert "1 checks failed." in wrong


@pytest.mark.gate
@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["nowhere"], "No simulator named 'nowhere' is installed"),
        (["turntable", "--address", "tcp:table.example:23"], "add --moves"),
        (["turntable", "--address", "here"], "Use sim:NAME"),
        (["nowhere", "--address", "sim:turntable"], "No driver named 'nowhere' is installed."),
    ],
)
def test_a_command_that_cannot_be_meant_says_what_to_do(argv, words):
    code, _, wrong = conform(*argv)
    assert code == 1
    assert words in wrong
