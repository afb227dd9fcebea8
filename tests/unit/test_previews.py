"""Previews in a process of their own: bounded in time and memory, whatever is asked."""

import msgspec
import pytest

from robots.kit import previews
from robots.kit.arms.described import posture
from robots.kit.description import load
from tests.conftest import at_length
from tests.packaged import of_spec
from tests.waiting import CEILING_S

READY = tuple(map(float, posture(load("pa10"), "ready")))


class Child:
    """The process, spoken to as the web process does."""

    def __init__(self, **env):
        import os
        import subprocess
        import sys

        from tests.rig import ROOT

        self.process = subprocess.Popen(
            [sys.executable, "-m", "robots.kit.previews"], cwd=ROOT, env={**os.environ, **env},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip

    def ask(self, driver, kind, args, joints=READY, **settings):
        body = msgspec.msgpack.encode(previews.Job(driver, settings, kind, args, joints, 7))
        self.process.stdin.write(previews.LENGTH.pack(len(body)) + body)
        self.process.stdin.flush()
        said = previews.read(self.process.stdout)
        return None if said is None else msgspec.json.decode(said)


@pytest.fixture
def child():
    made = []

    def start(**env):
        made.append(Child(**env))
        return made[-1]

    yield start
    for one in made:
        one.process.kill()
        one.process.wait()
        one.process.stdin.close()
        one.process.stdout.close()


def test_it_answers_as_the_driver_does(child):
    one = child()
    place = {"x": 0.5, "y": 0.16, "z": 0.15, "roll": 3.14159265, "pitch": 0.0, "yaw": 3.14159265}
    said = one.ask("pa10", "pose", place)
    assert (said["t"], said["n"], said["ok"]) == ("plan", 7, True)
    assert said["tool"][-1] == pytest.approx([0.5, 0.16, 0.15], abs=1e-4)
    assert "the table" in one.ask("pa10", "pose", place | {"z": -0.1})["text"]
    assert not one.ask("mercury", "up", {}, ())["ok"]
    assert not one.ask("nobody", "up", {}, ())["ok"]
    one.process.stdin.close()
    assert one.process.wait(CEILING_S) == 0


@pytest.mark.parametrize("value", [1e8, 1e308, 5e-324, *map(at_length, (1e4, -1e308, 0))])
def test_wild_numbers_end_nothing(child, value):
    one = child()
    for kind, args in (
        ("line", {"x": value, "y": value, "z": value}),
        ("pose", {"x": value, "y": 0, "z": 0, "roll": value, "pitch": 0, "yaw": 0}),
        ("joints", {f"j{i}": value for i in range(6)}), ("program", {"text": f"l {value:.0f} 0 0\nj {value} 0 0 0 0 0"}),
    ):  # fmt: skip
        said = one.ask("pa10", kind, args)
        if said is None:
            one = child()
        else:
            assert not said["ok"] or value in (5e-324, 0)
            assert said["text"].endswith(".") or said["ok"]
    assert one.ask("pa10", "ready", {})["ok"]


ROLLING = """
from robots.kit.contract.capabilities import Foreseen, Preview
from robots.kit.contract.channels import IN_PLANE
from robots.kit.contract.spec import CommandKind, Spec
def spec():
    return Spec("Rover", (CommandKind("roll", "Roll"),), pose=IN_PLANE, capabilities=(Preview("rover_robot.spec:foresee"),))
def foresee(kind, args, joints, settings):
    poses = {"short": ((0.0, 0.0),), "wild": ((0.0, float("nan"), 0.0),), "long": ((0.0, 0.0, 0.0),) * 5000}
    poses = poses.get(args["how"], ((0.0, 0.0, 0.0), (0.5, 0.0, 0.25)))
    times = {"late": (0.0,), "back": (1.0, 0.5), "before": (-1.0, 0.5), "wild": (0.0,)}
    times = times.get(args["how"], tuple(range(len(poses))))
    return Foreseen(seconds=1.0, poses=poses, times=times)
"""
GREEDY = """
from robots.kit.contract.capabilities import Foreseen, Preview
from robots.kit.contract.spec import CommandKind, Spec
def spec():
    kinds = (CommandKind("spin", "Spin"), CommandKind("eat", "Eat"), CommandKind("ok", "Ok"))
    return Spec("Greedy", kinds, capabilities=(Preview("greedy_robot.spec:foresee"),))
def foresee(kind, args, joints, settings):
    if kind == "spin":
        while True: pass
    if kind == "eat":
        held = [bytes(10_000_000) for _ in range(400)]
    if kind == "fall":
        return 1 / 0
    return Foreseen((), (), (), 0.0)
"""


def test_a_robot_without_joints_says_where_it_would_roll_in_its_own_frame(tmp_path, child):
    of_spec(tmp_path, "rover", ROLLING)
    one = child(PYTHONPATH=str(tmp_path))
    said = one.ask("rover", "roll", {"how": "well"}, ())
    assert (said["ok"], said["poses"], said["times"]) == (True, [[0.0, 0.0, 0.0], [0.5, 0.0, 0.25]], [0.0, 1.0])
    assert (said["joints"], said["path"], said["tool"]) == ([], [], [])
    for wrong in ("short", "wild", "long", "late", "back", "before"):
        assert one.ask("rover", "roll", {"how": wrong}, ())["text"] == previews.TOO_MUCH, wrong
    assert one.ask("rover", "roll", {"how": "well"}, ())["ok"]


@pytest.fixture
def greedy(tmp_path, child):
    of_spec(tmp_path, "greedy", GREEDY)
    return lambda: child(PYTHONPATH=str(tmp_path))


@pytest.mark.asvs("2.4.1", "15.2.2")
def test_what_runs_away_ends_the_process_and_what_eats_memory_is_refused(greedy):
    one = greedy()
    assert one.ask("greedy", "ok", {}, ())["ok"]
    assert one.ask("greedy", "eat", {}, ())["text"] == previews.TOO_MUCH
    assert one.ask("greedy", "fall", {}, ())["text"] == previews.TOO_MUCH
    assert one.ask("greedy", "ok", {}, ())["ok"]
    assert one.ask("greedy", "spin", {}, ()) is None
    assert one.process.wait(CEILING_S) < 0
