"""Checks of the spec, of `connect`, and of the content of states."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from math import isfinite

from robots.kit.conformance.report import NotApplicable, Note
from robots.kit.conformance.runs import error_text
from robots.kit.conformance.trial import Broken, Trial
from robots.kit.contract import capabilities as can
from robots.kit.contract.errors import HardwareFault
from robots.kit.contract.find import function, spec_of
from robots.kit.contract.session import RobotState
from robots.kit.description import views

READ = """
import sys, threading
from robots.kit.contract.find import spec_of
from robots.kit.installed import driver_path
spec_of(sys.argv[1])
driver = driver_path(sys.argv[1]).partition(':')[0]
loaded = [name for name in ('django', driver) if name in sys.modules]
print(*loaded, *(['a thread'] if threading.active_count() > 1 else []), sep=', ')
"""
PATHS: dict[type, tuple[str, ...]] = {
    can.Check: ("function",), can.JobCheck: ("function",), can.JobChoices: ("function",),
    can.Preview: ("function", "prepare"), can.ClickInPicture: ("resolve",), can.Calibration: ("procedure",),
    can.Stills: ("brightness",), can.Composite: ("scene",), can.Setting: ("check",),
}  # fmt: skip
CHILD_S = 120.0  # real time: a process that imports


def spec(trial: Trial) -> Iterator[str]:
    """The spec is read without its driver, a wire and Django, twice the same, and everything that it names exists."""
    for command in trial.spec.commands:
        if not command.label.strip():
            yield f"The command {command.kind!r} has no label; people see it on a button."
    for one in trial.spec.capabilities:
        yield from _found(one)
    if trial.description.get("camera", {}).get("by_driver") and not views(dict(trial.description)):
        yield "[camera] of robot.toml says by_driver, and names no view."
    if trial.name:
        yield from _read_apart(trial.name)


def _found(capability: object) -> Iterator[str]:
    for field in PATHS.get(type(capability), ()):
        path = getattr(capability, field)
        if not path:
            continue
        try:
            function(path)
        except Exception as error:  # noqa: BLE001 - of a package of somebody else
            yield f"{type(capability).__name__} names {path!r}, which cannot be imported: {error_text(error)}."


def _read_apart(name: str) -> Iterator[str]:
    try:
        done = subprocess.run(  # noqa: S603 - this interpreter
            [sys.executable, "-c", READ, name], capture_output=True, text=True, timeout=CHILD_S, check=False,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        yield "Reading the spec does not end; it has to be pure data."
        return
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["?"])[-1]
        yield f"The spec cannot be read in a process of its own: {last[:200]}"
    elif done.stdout.strip():
        yield f"Reading the spec loads {done.stdout.strip()}; spec.py has to be pure data, apart from the driver."
    made = [getattr(spec_of, "__wrapped__", spec_of)(name) for _ in range(2)]
    if made[0] != made[1]:
        yield "spec() returns something else each time; return the same data."


def connect(trial: Trial) -> Iterator[str]:
    """`connect` opens the line and returns a state; without a robot it raises HardwareFault with a sentence."""
    try:
        trial.ready_session()
    except Broken as error:
        yield f"{error} {'' if trial.faults is None else 'The simulator has no fault.'}".strip()
        return
    if trial.nowhere is None:
        return
    lost = trial.nowhere()
    call = trial.call(lost.connect, "connect")
    if not call.ends(trial.limits.answer_s + trial.limits.beyond_s):
        yield "connect() to an address where nothing is does not end."
    elif not isinstance(call.error, HardwareFault) or not str(call.error).strip():
        yield (
            f"connect() to an address where nothing is answers {error_text(call.error)}; "
            "raise LineGone with a sentence."
        )
    shut = trial.call(lost.close, "close")
    if not shut.ends(trial.limits.answer_s) or shut.error is not None:
        yield f"close() after a connect that failed raised {error_text(shut.error)}; it never raises."


def state(trial: Trial) -> Iterator[str]:
    """States are finite, complete, fresh on the session's clock and kept; also those seen in motions."""
    session = trial.ready_session()
    seen = [("state()", trial.state_from(session.state, "state")), ("hold()", trial.state_from(session.hold, "hold"))]
    for words, one in (*seen, *((f"In motion ({kind}) state()", one) for kind, one in trial.states.items())):
        yield from (f"{words} {wrong}" for wrong in wrong_in(trial, one))
    if trial.spec.pose and not any(one.pose for one in (*trial.states.values(), *(one for _, one in seen))):
        yield Note("No state told a pose: the robot never knew where it was.")
    for ask, words in ((session.state, "state()"), (session.hold, "hold()")):
        yield from _stamped(trial, ask, words)
    kept = session.latest()
    if kept is None:
        yield "latest() returns nothing after state(); call keep(state) with each state that is heard."


def _stamped(trial: Trial, ask: Callable[[], RobotState], words: str) -> Iterator[str]:
    """Yield a sentence if the stamp of a state is impossible."""
    before = trial.clock.monotonic()
    told = trial.state_from(ask, words.rstrip("()")).at
    after = trial.clock.monotonic()
    if not before - trial.limits.age_s <= told <= after:
        shown = f"{before:.1f} to {after:.1f}"
        yield f"{words} was heard at {told:.1f}, and the clock showed {shown}; stamp it by self.clock.monotonic()."


def wrong_in(trial: Trial, one: RobotState) -> Iterator[str]:
    """Yield what is wrong with a state, each as a sentence without its subject."""
    spec = trial.spec
    if len(one.joints) != len(spec.joints):
        yield f"tells {len(one.joints)} joints; the spec declares {len(spec.joints)}."
    coordinates = spec.pose.coordinates if spec.pose else ()
    if one.pose and len(one.pose) != len(coordinates):  # empty: it does not know where it is
        yield f"tells a pose of {len(one.pose)} numbers; the spec declares {len(coordinates)}."
    if one.twist and len(one.twist) != len(coordinates):
        yield f"tells a twist of {len(one.twist)} numbers for a pose of {len(coordinates)}; tell as many or none."
    for what, numbers in (("velocities", one.velocities), ("torques", one.torques)):
        if numbers and len(numbers) != len(spec.joints):
            yield f"tells {len(numbers)} {what} of {len(spec.joints)} joints; tell each or none."
    declared = {channel.name for channel in spec.channels}
    for name in set(one.values) - declared:
        yield f"tells the channel {name!r}, which the spec does not declare; declare it as a Scalar."
    for name in declared - set(one.values):
        yield f"does not tell the channel {name!r}, which the spec declares; tell it, or do not declare it."
    moves = (*one.velocities, *one.torques, *one.twist)
    told = {**spec.named(one), **{f"velocity {i}": v for i, v in enumerate(moves)}}
    for name, number in told.items():
        if not isinstance(number, int | float) or not isfinite(number):
            yield f"tells {number!r} for {name!r}; tell finite numbers."
        elif name in spec.joints and name in spec.scales and not _inside(trial, name, number):
            low, high = spec.scales[name].low, spec.scales[name].high
            yield f"tells {number:g} for the joint {name!r}, which its scale says lies in {low:g} to {high:g}."


def _inside(trial: Trial, name: str, number: float) -> bool:
    scale = trial.spec.scales[name]
    return scale.low <= number <= scale.high


def policies(trial: Trial) -> Iterator[str]:
    """The states of a motion tell every value that its policy bounds."""
    kinds = [(c, b) for c in trial.motions() for b in (c.policies.on_link_lost, c.policies.on_grant_end) if b]
    if not kinds:
        raise NotApplicable("every kind is held where its grant ends or the link is lost")
    seen = False
    for command, bound in kinds:
        one = trial.states.get(command.kind)
        if one is None:
            continue
        seen, told = True, trial.spec.named(one)
        lost = trial.spec.pose.coordinates if trial.spec.pose and not one.pose else ()
        for area in bound.area:
            if area.name in lost:
                yield Note(
                    f"The robot did not know where it was in {command.kind!r}, whose policy bounds {area.name!r}."
                )
            elif not isfinite(told.get(area.name, float("nan"))):
                yield f"The policy of {command.kind!r} bounds {area.name!r}, which its states do not tell; tell it."
        velocities, turn = trial.spec.speeds(one)
        if bound.speed is not None and not velocities:
            yield f"The policy of {command.kind!r} bounds the speed, and its states tell no velocities; tell them."
        if bound.turn is not None and turn is None:
            yield f"The policy of {command.kind!r} bounds how fast it turns, and its states tell no twist; tell it."
        if not bound.area and bound.speed is None and bound.turn is None:
            yield f"The policy of {command.kind!r} bounds neither place nor speed; give it an area or a speed."
    if not seen:
        raise NotApplicable("no kind with a policy was seen moving")
