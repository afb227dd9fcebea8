"""The conformance suite over every driver that is installed here, over the packages of tests, and from the command line."""

import json
import os
import shutil
import subprocess
from importlib.util import find_spec
from io import StringIO

import pytest
from django.core.management import CommandError, call_command

from robots.kit.conformance.installed import conform_installed
from robots.kit.conformance.report import Verdict
from robots.kit.conformance.suite import CHECKS
from robots.kit.conformance.trial import Limits
from tests.packaged import SHUTTLE, TURNTABLE, installed_from
from tests.rig import PYTHON, ROOT

# how many times faster than real time each simulator runs; the others run in real time
SPEED = {"mercury": 2.0, "pa10": 4.0, "puma": 4.0, "irat": 2.0, "srv1": 4.0}
OURS = sorted(file.parent.name for file in (ROOT / "robots/kit/drivers").glob("*/driver.py"))
# what a robot has nothing to show for, of its own spec and simulator
WITHOUT = {
    "mercury": {"replaced", "policies", "streams", "steered", "time left"},
    "pa10": {"policies", "time left"},
    "puma": {"replaced", "policies", "time left"},
    "irat": {"replaced", "policies", "steered", "time left"},
    "srv1": {"replaced", "streams"},
    "so101": {
        "held motions",
        "steered",
        "time left",
        "rests within",
        "replaced",
        "policies",
        "lanes",
        "pictures",
        "streams",
        "lost power",
    },
    "turntable": {
        "steered",
        "rests within",
        "held motions",
        "replaced",
        "lost line",
        "lost power",
        "noise",
        "pictures",
    },
    "shuttle": {
        "steered",
        "time left",
        "rests within",
        "held motions",
        "replaced",
        "policies",
        "lanes",
        "lost line",
        "lost power",
        "noise",
        "streams",
    },
}


def judged(name):
    speed = SPEED.get(name, 1.0)
    limits = Limits(answer_s=600.0, watch_s=1.5 * speed, beyond_s=600.0)
    report = conform_installed(name, f"sim:{name}", factor=speed, limits=limits)
    assert not report.failures, report.text()
    assert {r.check for r in report.results if r.verdict == Verdict.NOT_APPLICABLE} <= WITHOUT[name], report.text()
    assert [r.check for r in report.results] == list(CHECKS)


@pytest.mark.timed
@pytest.mark.parametrize("name", OURS)
def test_every_driver_of_ours_conforms(name):
    if name == "so101" and find_spec("lerobot") is None:
        pytest.skip("LeRobot is an optional extra: make test-lerobot")
    judged(name)


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


def told(*argv, status=0):
    """Return what the command says, and its complaint; its exit status is that."""
    out, complaint, code = StringIO(), "", 0
    try:
        call_command("conform", *argv, stdout=out)
    except CommandError as error:
        complaint, code = str(error), error.returncode
    assert code == status, out.getvalue() + complaint
    return out.getvalue(), complaint


def test_the_command_tells_a_third_party_that_its_driver_is_in_order(tmp_path, installed):
    file = tmp_path / "report.json"
    said, _ = told("turntable", "--only", "spec", "--only", "connect", "--json", str(file))
    assert "turntable at sim:turntable, a simulator that is started for it." in said
    assert "2 passed, 0 failed, 0 not applicable." in said
    assert [r["verdict"] for r in json.loads(file.read_text())["results"]] == ["passed", "passed"]


HOLD = '        self._ask(do="hold")\n', "        self.state()\n"
CHECK = '        check("turntable", kind, args, self.settings)\n', ""
HANDOVER = 'handover=("home",)', 'handover=("rest",)'
DRIVER = "def spec():", "def spec():\n    import turntable_robot.driver"


@pytest.mark.parametrize(
    ("file", "change", "check", "words"),
    [
        ("driver.py", HOLD, "hold", "returned a state that moves"),
        ("driver.py", CHECK, "values", "refuse it with BadRequest"),
        ("spec.py", HANDOVER, "spec", "has no command 'rest', which its handover names"),
        ("spec.py", DRIVER, "spec", "loads turntable_robot.driver"),
    ],
)
def test_the_command_names_what_is_broken_and_its_status_is_1(tmp_path, monkeypatch, file, change, check, words):
    with installed_from(broken(tmp_path, file, change), monkeypatch):
        said, complaint = told("turntable", "--only", check, status=1)
    assert words in said
    assert complaint == "1 of 1 checks failed."


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["nowhere"], "No simulator named 'nowhere' is installed"),
        (["turntable", "--address", "tcp:table.example:23"], "add --moves"),
        (["turntable", "--address", "here"], "Use sim:NAME"),
        (["nowhere", "--address", "sim:turntable"], "No driver named 'nowhere' is installed."),
        (["turntable", "--speed", "4", "--only", "spec"], "The simulator 'turntable' did not start"),
    ],
)
def test_a_command_that_cannot_be_meant_says_what_to_do(installed, argv, words):
    assert words in told(*argv, status=1)[1]


def test_the_installed_command_ends_with_status_1(tmp_path):
    code = "from portal.command import main; main()"
    done = subprocess.run(
        [PYTHON, "-c", code, "conform", "turntable", "--only", "spec"], cwd=ROOT, capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": str(broken(tmp_path, "spec.py", HANDOVER))}, check=False,
    )  # fmt: skip
    assert done.returncode == 1, done.stderr
    assert "turntable" in done.stdout
    assert "has no command 'rest'" in done.stdout
