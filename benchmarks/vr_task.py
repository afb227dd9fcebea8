"""Four scripted operators lift the hanging rod and build a tower of three, over a thin line: by pictures, jog, ghost, task.

In virtual time: the PUMA 560's simulator and its driver, which goes by belief, without pictures of its own. The line is a
model: bytes a second each way and a delay. No person took part: the times of hands and thoughts are those of the
keystroke-level model (Card, Moran, Newell 1980), and who steers over a delay moves, waits and looks (Ferrell 1965).
`operator_s` is how long the person is needed.
"""

import contextlib
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.stage import set_up, tell

Pose = NDArray[np.float64]
BOOT_S = 3.0
LINES = (100.0, 1000.0)  # bytes a second
ROUND_TRIP_S = 0.3
POINT_S, PRESS_S, HOMING_S, THINK_S = 1.1, 0.1, 0.4, 1.35  # the keystroke-level model: P, B, H, M
TIMING = 0.1  # standard deviation of a hand's timing, as a share of the time (Wearden 1991)
COMMAND, STATE, ANSWERS = 30, 20, 300  # bytes on the line: a command, a state, what tells how a command goes
PIXELS_OFF = 1.0  # standard deviation of what an eye reads in a picture
TAP_S = 0.3  # the shortest time for which a control is held
SLOW, FAST = 0.15, 1.0  # of a jog's speed
NEAR_M, NEAR_RAD = 0.0006, 0.02  # near enough for the fingers and for the studs
MOST_LOOKS = 400
GIVEN_UP_S = 3600.0
TASKS = {"rod": "grasp rod\nmove 550 300 340", "tower": "put b on a\nput c on b"}
ROD_M, BRICK_M, OFF_M = 0.335, 0.0192, 0.001
MOST_S, SHARE = 60.0, 0.2  # goals: rod by ghost at 100 bytes a second, tower by task; operator's time by task of jog's


@dataclass
class Result:
    """How long an operator was needed, how long all took (s), and whether it was done by the simulator's truth."""

    operator_s: float
    total_s: float
    done: bool


class Room:
    """The arm in a world, a driver's session, and a person with an operator's line."""

    def __init__(self, folder: Path, bytes_s: float, seed: int) -> None:
        from robots.kit.arms.described import chain
        from robots.kit.drivers.puma.checks import planner_for
        from tests.world.puma import PumaRig
        from tests.world.world import World

        self.world, self.bytes_s, self.dice = World(seed), bytes_s, Random(seed)
        self.rig = PumaRig(self.world, folder)
        self.session: Any = self.rig.session("puma", "", {"epoch": 1})
        self.chain, self.planner = chain("puma"), planner_for({})

    def begin(self) -> None:
        """Connect, calibrate, and go to where a turn begins."""
        self.world.sleep(BOOT_S)
        self.session.connect()
        self.session.recover(lambda: None)
        self.session.execute("ready", {}, lambda: None, lambda stage: None)

    def think(self, *parts: float) -> None:
        """Let a person need so long (s)."""
        self.world.sleep(sum(parts))

    def carry(self, size: int) -> None:
        """Let the line carry so many bytes, one way."""
        self.world.sleep(size / self.bytes_s + ROUND_TRIP_S / 2)

    def send(self, kind: str, args: dict[str, Any]) -> None:
        """Send a command, and wait until the page has told its end."""
        self.carry(COMMAND)
        self.session.execute(kind, args, lambda: None, lambda stage: None)
        self.carry(ANSWERS + STATE)

    def hold(self, args: dict[str, float], seconds: float) -> None:
        """Hold a control of `jog_tool` for so long; the line carries its beginning and its end equally late."""
        from robots.kit.clock import Limit
        from robots.kit.contract.errors import NotPermitted

        self.carry(COMMAND)
        held = Limit(self.world, seconds)

        def permit() -> None:
            if held.over:
                raise NotPermitted("The hand has let go.")

        with contextlib.suppress(NotPermitted):
            self.session.execute("jog_tool", args, permit, lambda stage: None)
        self.session.hold()

    def tool(self) -> Pose:
        """Return the tool's pose (4 x 4), as the newest state tells it."""
        return np.array(self.chain.forward(np.array(self.session.state().joints)))

    def acts(self, text: str) -> list[Any]:
        """Return what the arm has to do for a task."""
        from robots.kit.arms.tasks.parsing import parse
        from robots.kit.arms.tasks.planning import plan

        return plan(
            self.planner, parse(text), self.session.tasks.model.arrangement, np.array(self.session.state().joints)
        )

    def done(self, name: str) -> bool:
        """Tell whether the rod was lifted, or the tower stands, by the simulator's truth."""
        there = self.rig.sim.status()["objects"]
        if name == "rod":
            return bool(there["rod"][2] > ROD_M)
        a, b, c = (np.array(there[brick]) for brick in "abc")
        up = np.array([0.0, 0.0, BRICK_M])
        return bool(np.abs(b - a - up).max() < OFF_M and np.abs(c - a - 2 * up).max() < OFF_M)


def by_task(room: Room, text: str) -> float:
    """Choose each line as a block with its objects, send all at once, and leave."""
    begun = room.world.monotonic()
    for line in text.splitlines():
        blocks = 1 + len(line.split()[1:])  # the block, and what is chosen or typed in it
        room.think(THINK_S, blocks * (POINT_S + PRESS_S))
    room.think(THINK_S, POINT_S, PRESS_S)
    needed = room.world.monotonic() - begun
    room.send("task", {"text": text})
    return needed


def by_ghost(room: Room, text: str) -> float:
    """Drag the ghost to each place, where it snaps, and send it; planning goes on while the arm moves."""
    begun, closed = room.world.monotonic(), 0.0
    for act in room.acts(text):
        if act.kind == "gripper":
            if act.args["closed"] != closed:
                closed = act.args["closed"]
                room.think(POINT_S, PRESS_S)
                room.send(act.kind, act.args)
            continue
        room.think(THINK_S, 2 * POINT_S, 2 * PRESS_S)  # to the handle, and with it to the place
        room.think(POINT_S, PRESS_S)
        room.send(act.kind, act.args)
    return room.world.monotonic() - begun


def by_jog(room: Room, text: str) -> float:
    """Hold a button for each direction, let go, wait for the state, look, and again until it is near enough."""
    return _steered(room, text, lambda: (room.carry(STATE), room.tool())[1])


def by_pictures(room: Room, text: str) -> float:
    """The same, seen in coarse pictures of the front camera alone: no nearer than an eye reads them."""
    from workers.media.steps import COARSE_QUALITY, jpeg

    size, off = len(jpeg(room.rig.cameras.take("front"), COARSE_QUALITY)), PIXELS_OFF * _pixel_m()

    def look() -> Pose:
        pose = room.tool()
        room.carry(size)
        pose[:3, 3] += [room.dice.gauss(0.0, off) for _ in range(3)]
        return pose

    return _steered(room, text, look, 2 * off)


def _pixel_m() -> float:
    """Return the width of a pixel of the front camera, at the point in the middle of its picture (m)."""
    from robots.kit.description import load

    description = load("puma")
    view = next(one for one in description["view"] if one["name"] == "front")
    far = float(np.linalg.norm(np.subtract(view["place"], view["at"])))
    return 2 * far * float(np.tan(np.radians(view["field_deg"]) / 2)) / float(description["camera"]["width"])


def _steered(room: Room, text: str, look: Callable[[], Pose], near_m: float = NEAR_M) -> float:
    begun, closed = room.world.monotonic(), 0.0
    for act in room.acts(text):
        if act.kind != "gripper":
            _steer(room, room.chain.forward(act.path.at(act.path.seconds)[0]), look, near_m)
        elif act.args["closed"] != closed:
            closed = act.args["closed"]
            room.think(POINT_S, PRESS_S)
            room.send(act.kind, act.args)
    return room.world.monotonic() - begun


def _steer(room: Room, goal: Pose, look: Callable[[], Pose], near_m: float) -> None:
    """Steer the tool to a pose, the direction that is farthest off first."""
    from scipy.spatial.transform import Rotation

    from robots.kit.arms.commands import PLACE
    from robots.kit.arms.jogs import JOG_M_S, JOG_RAD_S

    full = np.array([JOG_M_S] * 3 + [JOG_RAD_S] * 3)
    for _ in range(MOST_LOOKS):
        pose = look()
        room.think(THINK_S)
        turn = Rotation.from_matrix(goal[:3, :3] @ pose[:3, :3].T).as_rotvec()
        off = np.append(goal[:3, 3] - pose[:3, 3], turn)
        axis = int(np.argmax(np.abs(off) / ([near_m] * 3 + [NEAR_RAD] * 3)))
        if abs(off[axis]) <= (near_m if axis < 3 else NEAR_RAD):
            return
        share = float(np.clip(abs(off[axis]) / full[axis], SLOW, FAST))
        seconds = max(TAP_S, abs(off[axis]) / full[axis] / share) * room.dice.gauss(1.0, TIMING)
        share = min(share, abs(off[axis]) / full[axis] / TAP_S)
        room.think(POINT_S, PRESS_S)
        room.hold({PLACE[axis]: float(np.copysign(share, off[axis]))}, seconds)


OPERATORS: dict[str, Callable[[Room, str], float]] = {
    "pictures": by_pictures, "jog": by_jog, "ghost": by_ghost, "task": by_task,
}  # fmt: skip


def run(operator: str, name: str, bytes_s: float, seed: int = 1) -> Result:
    """Let an operator do a task once."""
    results: list[Result] = []
    with tempfile.TemporaryDirectory() as folder:
        room = Room(Path(folder), bytes_s, seed)

        def person() -> None:
            room.begin()
            begun = room.world.monotonic()
            needed = OPERATORS[operator](room, TASKS[name])
            total = room.world.monotonic() - begun
            room.think(1.0)
            results.append(Result(needed, total, room.done(name)))

        room.world.spawn(person, "person", room.world.process("person", delayed=False))
        try:
            room.world.until(lambda: results, GIVEN_UP_S, "the end of the task")
        finally:
            room.world.close()
            room.rig.close()
    return results[0]


def main() -> None:
    """Let each operator do both tasks, over each line."""
    set_up()
    found = {}
    for bytes_s in LINES:
        for operator in OPERATORS:
            for name in TASKS:
                found[operator, name, bytes_s] = one = run(operator, name, bytes_s)
                end = "done" if one.done else "not done"
                print(
                    f"{bytes_s:g} bytes/s, {name} by {operator}: needed {one.operator_s:.0f} s, {one.total_s:.0f} s in all, {end}"
                )
    thin = LINES[0]
    share = max(found["task", name, thin].operator_s / found["jog", name, thin].operator_s for name in TASKS)
    rod, tower = found["ghost", "rod", thin], found["task", "tower", thin]
    holds = share <= SHARE and max(rod.total_s, tower.total_s) <= MOST_S and rod.done and tower.done
    beside = {
        f"{name}_by_{operator}_at_{bytes_s:g}": [round(one.operator_s), round(one.total_s), one.done]
        for (operator, name, bytes_s), one in found.items()
    }
    tell(
        "vr_task", round(share, 3), "of the time of an operator who jogs, by task, the worse of two",
        f"<= {SHARE}; at {thin:g} bytes/s the rod by ghost and the tower by task within {MOST_S:g} s", holds, beside,
    )  # fmt: skip


if __name__ == "__main__":
    main()
