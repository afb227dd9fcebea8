"""Any robot of the LeRobot library (https://github.com/huggingface/lerobot, 0.3 and 0.4).

`robot.toml` names the class under `[lerobot]`, and for each feature of its actions unit, range, speed and ready
position (`lerobot_spec.py`). So the controls are drawn without the library. A robot whose class has other features is
refused at `connect`. LeRobot sends goals, and a servo moves to them as fast as it can. Here the path to a goal is cut
into small steps with a permit for each, so that the speed is limited and a stop ends the motion.
"""

import threading
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from math import ceil
from pathlib import Path
from typing import Any, TypeVar

from robots.kit.clock import Limit
from robots.kit.contract.errors import HardwareFault, LineBusy, LineGone, LineSilent, why
from robots.kit.contract.session import OnStage, Outcome, Permit, RobotState, Session, Trace
from robots.kit.contract.values import check, number
from robots.kit.description import load
from robots.kit.drivers.lerobot_spec import REST_S, features
from robots.kit.drivers.permits import unless_held, until_held
from robots.kit.opening import is_in_use, why_not

STEP_S = 1 / 30  # between two goals of a path
TRIES = 3  # goals and questions can be repeated
STILL = 0.004  # of a feature's range: two readings that differ by less mean rest
LOOK_S = 0.06
REACHED = 0.03  # of a feature's range: this close counts as reached
T = TypeVar("T")


def _class_and_config(about: dict[str, Any]) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return the robot's class and its configuration. Raises LookupError."""
    problem: ImportError | None = None
    for module in about["modules"]:  # versions of LeRobot have it in different modules
        try:
            import_module(module)
            break
        except ImportError as error:
            problem = error
    else:
        raise LookupError(f"LeRobot, or a part of it that this robot needs, is not installed: {problem}") from problem
    robots = import_module("lerobot.robots")
    make = import_module("lerobot.robots.utils").make_robot_from_config
    return make, robots.RobotConfig.get_choice_class(about["type"])


def make_robot(about: dict[str, Any], port: str, calibrated: Path | None) -> Any:
    """Return LeRobot's object for `port`; opens nothing. Raises LookupError."""
    make, config = _class_and_config(about)
    return make(config(port=port, id=about["id"], calibration_dir=calibrated, **about.get("options", {})))


class LeRobotDriver(Session):
    """A `robots.kit.contract.session.Session`; subclasses name the folder of the robot in `described`."""

    described: str

    def __init__(self, address: str, settings: dict[str, Any], trace: Trace | None = None) -> None:
        super().__init__(address, settings, trace)
        self._listed, self._about = features(self.described), load(self.described)["lerobot"]
        _class_and_config(self._about)  # fails early without the library
        self._address = address
        self._robot: Any = None
        self._line = threading.RLock()
        self._holds = 0

    def connect(self) -> RobotState:
        """Open the line and ask for the state. Refuses a robot that was never calibrated; people must do that."""
        kept = Path(self._address).with_name("calibration")  # a simulated robot has its own
        self.close()
        with self._line:
            self._robot = make_robot(self._about, self._address, kept if kept.is_dir() else None)
            told = {key for key, kind in self._robot.action_features.items() if kind is float}
            if told != {f.key for f in self._listed}:
                self.close()
                raise HardwareFault(f"LeRobot's class has the features {sorted(told)}; describe each in robot.toml.")
            try:
                self._ask(lambda robot: robot.connect(calibrate=False))
            except (LineGone, LineSilent) as error:
                fault = LineBusy if is_in_use(error) else LineGone
                raise fault(f"The robot's serial port cannot be opened: {why_not(error, self._address)}") from error
            if not self._ask(lambda robot: robot.is_calibrated):
                self.close()
                raise HardwareFault(
                    "The robot is not calibrated: run lerobot-calibrate on its machine with "
                    f"--robot.type={self._about['type']} --robot.id={self._about['id']}."
                )
        return self.state()

    def close(self) -> None:
        """Close the connection."""
        with self._line:
            robot, self._robot = self._robot, None
            if robot is not None:
                with suppress(Exception):
                    robot.disconnect()

    def _ask(self, what: Callable[[Any], T], tries: int = 1) -> T:
        """Call LeRobot's object and translate its errors. Raises LineGone, LineSilent, HardwareFault."""
        if self._robot is None:
            raise LineGone("The robot is not connected.")
        for left in range(tries - 1, -1, -1):
            try:
                return what(self._robot)
            except ConnectionError as error:
                if not left:
                    raise LineSilent(f"The robot does not answer: {why(error)}.") from error
            except OSError as error:  # pyserial's own errors are OSErrors
                raise LineGone(f"The connection to the robot is lost: {why(error)}.") from error
            except Exception as error:
                raise HardwareFault(f"LeRobot says: {why(error)}.") from error
        raise AssertionError

    def state(self) -> RobotState:
        """Read an observation."""
        before = self._latest
        with self._line:
            seen = self._observe()
        joints = tuple(v * f.scale for v, f in zip(seen, self._listed, strict=True))
        now = self.clock.monotonic()
        moving = before is not None and now - before.at < 1.0 and not self._alike(before.joints, joints)
        return self.keep(RobotState(now, joints, (), moving, True))

    def _observe(self) -> tuple[float, ...]:
        seen = self._ask(lambda robot: robot.get_observation(), TRIES)
        return tuple(float(seen[f.key]) for f in self._listed)

    def _alike(self, one: tuple[float, ...], other: tuple[float, ...], share: float = STILL) -> bool:
        return all(
            abs(a - b) <= share * (f.high - f.low) * f.scale for a, b, f in zip(one, other, self._listed, strict=True)
        )

    def execute(self, kind: str, args: dict[str, Any], permit: Permit, on_stage: OnStage) -> Outcome:
        """Move to the goal in small steps; the outcome has the goal that LeRobot reports as sent."""
        check(self.described, kind, args, self.settings)
        free = unless_held(lambda: self._holds)
        go_on = until_held(permit, lambda: self._holds)
        permit()
        if kind == "noop":
            return Outcome({}, self.state())
        with self._line:
            start = self._observe()
        if kind == "ready":
            goal = tuple(f.ready for f in self._listed)
        else:
            goal = tuple(
                number(args, f.name) / f.scale if f.name in args else here
                for f, here in zip(self._listed, start, strict=True)
            )
        sent = self._go(start, goal, free, permit, on_stage)
        state = self._at_rest(go_on) or self.state()
        told = {f.name: round(sent[f.key] * f.scale, 6) for f in self._listed}
        there = dict(zip(told, state.joints, strict=True))
        off = [f.name for f in self._listed if abs(told[f.name] - there[f.name]) > REACHED * (f.high - f.low) * f.scale]
        if off:
            raise HardwareFault(f"{off[0]} came to rest before it was there; something may be in its way.")
        return Outcome(told, state)

    def _go(
        self, start: tuple[float, ...], goal: tuple[float, ...], free: Permit, permit: Permit, on_stage: OnStage
    ) -> dict[str, float]:
        """Send goal after goal, at most at the speed of the slowest feature. Return the last goal as it was sent."""
        seconds = max(abs(g - s) / f.speed for g, s, f in zip(goal, start, self._listed, strict=True))
        steps = max(1, ceil(seconds / STEP_S))
        sent: dict[str, float] = {}
        for k in range(1, steps + 1):
            step = Limit(self.clock, STEP_S)
            permit()
            share = k / steps
            action = {f.key: s + share * (g - s) for f, s, g in zip(self._listed, start, goal, strict=True)}
            with self._line:
                free()
                sent = self._ask(lambda robot, action=action: robot.send_action(action), TRIES)  # type: ignore[misc]
            if k == 1:
                on_stage("sent")
                on_stage("acknowledged")
            if k % 3 == 0:
                self.state()
            self.clock.sleep(step.remaining)
        return sent

    def _at_rest(self, check: Callable[[], None]) -> RobotState | None:
        """Return the state once two readings are alike; None if that takes too long."""
        limit = Limit(self.clock, REST_S)
        before = self.state()
        while not limit.over:
            self.clock.sleep(LOOK_S)
            check()
            state = self.state()
            if self._alike(before.joints, state.joints):
                return state
            before = state
        return None

    def hold(self) -> RobotState:
        """Send the present position as goal; no earlier goal follows."""
        with self._line:
            self._holds += 1
            here = self._observe()
            action = {f.key: v for f, v in zip(self._listed, here, strict=True)}
            self._ask(lambda robot: robot.send_action(action), TRIES)
        state = self._at_rest(lambda: None)
        if state is None:
            raise HardwareFault("The robot did not come to rest after a hold.")
        return state

    def recover(self, permit: Permit) -> RobotState:
        """Soft reset: open the line again. LeRobot has no other reset, and nothing is moved."""
        permit()
        return self.connect()
