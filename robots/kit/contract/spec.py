"""The spec of a robot: pure data, readable without its driver, a wire or Django."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import hypot, inf
from typing import Any, Literal, TypeVar

from robots.kit.contract.capabilities import (
    Composite,
    GoodWhile,
    Idle,
    JobCheck,
    JobChoices,
    JobMovies,
    Need,
    Objects,
    Preview,
    PrivacyMasks,
    Programs,
    Setting,
    Statistics,
    Stills,
)
from robots.kit.contract.channels import LENGTHS, MOST, Pose, Scalar, Scale
from robots.kit.contract.policies import HOLD, Policies
from robots.kit.contract.ranges import from_to
from robots.kit.contract.session import RobotState
from robots.kit.contract.streams import MOST as MOST_STREAMS
from robots.kit.contract.streams import Stream
from robots.kit.contract.tidying import Tidy

Lane = Literal["motion", "config"]
OWNERS = ("epoch", "folder", "token")  # settings of every driver beside those that its spec declares
TURN, ANYONE, STAFF = "turn", "anyone", "staff"
C = TypeVar("C")


@dataclass(frozen=True)
class Argument:
    """One value of a command: name, unit, inclusive range; of a text, the range of its length in characters.

    `whole`: a number without a fraction. `label` is what forms call it, `help` a sentence that explains it. `number` is
    for a text that a channel shows (`CommandKind.shown`): the function that gives its number, as `package.module:name`.
    `directions`: words for more and less of it, as ("right", "left"), than before; with a `label`, than what they name.
    """

    name: str
    unit: str
    low: float
    high: float
    required: bool = True
    text: bool = False
    whole: bool = False
    label: str = ""
    help: str = ""
    number: str = ""
    directions: tuple[str, str] | tuple[()] = ()
    share: str = ""  # what follows its value in per cent, where 1 is the whole, as "of full speed"

    @property
    def title(self) -> str:
        """Return what forms call it."""
        return self.label or self.name.replace("_", " ")

    @property
    def bounds(self) -> str:
        """Return its range in words, as "0.5 to 3 m"."""
        return from_to(self.low, self.high, self.unit)


@dataclass(frozen=True)
class CommandKind:
    """A command that a robot understands.

    `level` is the clearance that it needs. `asked_by` says who may ask for it: the person whose turn it is (`turn`),
    everybody with enough clearance, as a job that waits (`anyone`), staff (`staff`); where it names none, the portal
    alone gives it. `limit_s` is its longest time (s). One command of the lane `motion` runs at a time; one of the lane
    `config` runs beside it: it is not for jobs, and `default` holds the arguments that handover restores after a turn.
    `shown` names, by argument, the joint, coordinate or channel that shows its value at the end: so a setting is
    confirmed, and set again where the robot has forgotten it, and drawn consoles offer a motion's way back. `says`
    tells what it does, for logs (see `words.py`), in place of its label.
    """

    kind: str
    label: str
    arguments: tuple[Argument, ...] = ()
    level: int = 1
    limit_s: float = 15.0
    lane: Lane = "motion"
    asked_by: frozenset[str] = frozenset({TURN})
    default: Mapping[str, Any] | None = None
    shown: Mapping[str, str] = field(default_factory=dict)
    moves: bool = True
    still_after: bool = True  # a new stable picture belongs to its end, where there is a camera
    held: bool = False  # it begins and goes on only while keep-alives arrive
    steered: bool = False  # while it is held, keep-alives may carry newer values: `Session.steered`
    replaceable: bool = False  # a newer one may take its place in motion; its driver asks `permit` on the way
    policies: Policies = HOLD  # at the end of its grant and without a connection
    says: str = ""

    def open_to(self, who: str) -> bool:
        """Tell whether `who` (`turn`, `anyone`, `staff`) may ask for it."""
        return who in self.asked_by


@dataclass(frozen=True)
class Spec:
    """The commands, values and capabilities of a robot.

    `handover` names the commands that put it in order between two turns, `channels` the values that it tells beside its
    joints, `streams` its byte streams, `pose` the coordinates of its pose, where it has one. `rest_s` is the longest
    time (s) after which it rests by itself when no message reaches it any more; None where it is not known. With
    `scales` for all numbers that its states tell, by name, and with the controller's usual words, `modes`, states for
    slow lines take few bytes (see `compact.py`). Raises ValueError where one part of it contradicts another.
    """

    name: str
    commands: tuple[CommandKind, ...]
    joints: tuple[str, ...] = ()
    handover: tuple[str, ...] = ()
    channels: tuple[Scalar, ...] = ()
    capabilities: tuple[Any, ...] = ()
    streams: tuple[Stream, ...] = ()
    rest_s: float | None = None
    pose: Pose | None = None
    scales: Mapping[str, Scale] = field(default_factory=dict)
    modes: tuple[str, ...] = ("",)
    words: Mapping[str, str] = field(default_factory=dict)  # plain ones for its names: `[words]` of its robot.toml

    def __post_init__(self) -> None:
        """Refuse a spec that contradicts itself, before anybody uses it. Raises ValueError."""
        wrong = next(_contradictions(self), "")
        if wrong:
            raise ValueError(f"The spec of {self.name!r} {wrong}.")

    def names(self) -> list[str]:
        """Return the names of everything that a state tells as a number: joints, coordinates of the pose, channels."""
        return [*self.joints, *(self.pose.coordinates if self.pose else ()), *(c.name for c in self.channels)]

    def packed(self) -> tuple[Scalar, ...]:
        """Return what state packets carry beside the joints: the channels, then the coordinates of a packed pose."""
        return (*self.channels, *(self.pose.scalars() if self.pose and self.pose.packed else ()))

    def carried(self) -> tuple[str, ...]:
        """Return the coordinates of the pose that packets carry; none where a console works it out from the joints."""
        return self.pose.coordinates if self.pose and self.pose.packed else ()

    def body(self, state: RobotState) -> tuple[float, ...]:
        """Return the body's velocity where packets tell it: the state knows it, and they carry the pose. Else empty."""
        carried = self.carried()
        return state.twist if carried and len(state.twist) == len(carried) else ()

    def posture(self, state: RobotState) -> tuple[float, ...]:
        """Return what a picture tells of the robot's pose: its joints, then a packed pose and the body's velocity.

        The joints alone where the state does not tell as many joints and coordinates as are declared.
        """
        carried = self.carried()
        if len(state.joints) != len(self.joints) or len(state.pose) != len(carried):
            return state.joints
        return (*state.joints, *state.pose, *self.body(state))

    def named(self, state: RobotState) -> dict[str, float]:
        """Return what a state tells, by name."""
        coordinates = self.pose.coordinates if self.pose else ()
        joints = dict(zip(self.joints, state.joints, strict=False))
        return joints | dict(zip(coordinates, state.pose, strict=False)) | dict(state.values)

    def speeds(self, state: RobotState) -> tuple[tuple[float, ...], float | None]:
        """Return the velocities of all joints and of the body (rad/s, m/s), and how fast the body turns (rad/s).

        Empty where a joint's is not told or nothing is; None where the body's is not told.
        """
        if len(state.velocities) != len(self.joints):
            return (), None
        axes = self.pose.coordinates if self.pose else ()
        if not axes or len(state.twist) != len(axes):
            return state.velocities, None
        along = [v for axis, v in zip(axes, state.twist, strict=True) if axis in LENGTHS]
        about = [v for axis, v in zip(axes, state.twist, strict=True) if axis not in LENGTHS]
        return (*state.velocities, hypot(*along)), hypot(*about)

    def readings(self, state: Mapping[str, Any]) -> tuple[tuple[str, float, str], ...]:
        """Return name, value and unit of what a kept state (`pose`, `values`) tells, as far as it is declared."""
        values = dict(state.get("values") or {})
        if self.pose is not None:
            values |= zip(self.pose.coordinates, state.get("pose") or (), strict=False)
        declared = (*(self.pose.scalars() if self.pose else ()), *self.channels)
        return tuple((c.name, values[c.name], c.unit) for c in declared if c.name in values)

    def command(self, kind: str) -> CommandKind | None:
        """Return the command of that kind, or None."""
        return next((c for c in self.commands if c.kind == kind), None)

    def capability(self, kind: type[C]) -> C | None:
        """Return what the robot declares of that kind of capability (see `capabilities.py`), or None."""
        return next((c for c in self.capabilities if isinstance(c, kind)), None)

    def all_of(self, kind: type[C]) -> tuple[C, ...]:
        """Return every capability of that kind, in the order of the declaration."""
        return tuple(c for c in self.capabilities if isinstance(c, kind))

    def filmed(self) -> tuple[str, ...]:
        """Return the kinds of jobs of which a movie is made by itself: programs, and those that it declares."""
        declared = (kind for one in self.all_of(JobMovies) for kind in one.kinds)
        return tuple(dict.fromkeys((*(one.kind for one in self.all_of(Programs)), *declared)))

    def settings(self) -> tuple[Setting, ...]:
        """Return what staff may set for the robot: its own settings, then those of its stills and masks."""
        masks = (one.setting() for one in self.all_of(PrivacyMasks))
        return (*self.all_of(Setting), *(s for stills in self.all_of(Stills) for s in stills.settings()), *masks)

    def for_driver(self, settings: Mapping[str, Any]) -> dict[str, Any]:
        """Return what staff have set of the robot's own settings, by name."""
        found = ((setting.name, _usable(setting, settings.get(setting.name))) for setting in self.all_of(Setting))
        return {name: value for name, value in found if value is not None}

    def rests_within(self, kind: str, settings: Mapping[str, Any] | None) -> float | None:
        """Return within how many seconds it rests without a message if that kind of command ran; None: not known.

        `settings` are the robot's; None: the highest that staff may set, because a motion keeps the values with
        which it began. A motion that may go on without the live link may do so without its owner.
        """
        if settings is None:
            settings = {setting.name: setting.high for setting in self.all_of(Setting)}
        found = self.command(kind)
        alone = found.policies.by(self.for_driver(settings)).on_link_lost if found else None
        return self.rest_s if self.rest_s is None or alone is None else self.rest_s + alone.seconds

    def stills(self, settings: Mapping[str, Any]) -> Stills | None:
        """Return how pictures at rest are taken, with what staff have set; None where the spec does not say."""
        stills = self.capability(Stills)
        if stills is None:
            return None
        threshold, exposure_s = (_usable(setting, settings.get(setting.name)) for setting in stills.settings())
        return replace(stills, threshold=threshold or stills.threshold, exposure_s=exposure_s or stills.exposure_s)


def _usable(setting: Setting, value: Any) -> Any:
    """Return a kept value as it is used: a number inside the range, which may be narrower than when it was kept."""
    if setting.kind == "list":
        return value if isinstance(value, list) and value else None
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < inf:
        return None
    return float(min(max(value, setting.low), setting.high))  # an integer may be larger than any float


def _contradictions(spec: Spec) -> Iterator[str]:
    """Yield what is wrong with a spec, each as the end of a sentence that begins with the spec's name."""
    for what, names in (
        ("command", [c.kind for c in spec.commands]),
        ("joint, coordinate or channel", spec.names()),
        ("stream", [s.name for s in spec.streams]),
        ("composite", [c.name for c in spec.all_of(Composite)]),
        ("setting", [*OWNERS, *(setting.name for setting in spec.settings())]),
    ):
        yield from (f"names the {what} {name!r} twice" for name in _twice(names))
    told = set(spec.names())
    yield from (f"has a scale for {name!r}, which it does not tell" for name in spec.scales if name not in told)
    yield from (f"names the word {word!r} twice" for word in _twice(list(spec.modes)))
    for command in spec.commands:
        yield from (f"{wrong} in its command {command.kind!r}" for wrong in _wrong_in(command, told))
        yield from (f"{wrong} in its command {command.kind!r}" for wrong in _wrong_bounds(command, spec, told))
    numbers = len(spec.packed()) + len(spec.carried())  # with the body's velocity
    for what, count, most in (("channels", numbers, MOST), ("streams", len(spec.streams), MOST_STREAMS)):
        if count > most:
            yield f"has {count} {what}; at most {most} are possible"
    yield from (f"gives the channel {c.name!r} no range" for c in spec.channels if not -inf < c.low <= c.high < inf)
    if spec.rest_s is not None and not 0 <= spec.rest_s < inf:
        yield f"says that the robot rests by itself after {spec.rest_s:g} s"
    for kind in spec.handover:
        yield from _wrong_motion(kind, "handover", spec)
        found = spec.command(kind)
        if found is not None and found.lane == "motion" and found.held:
            yield f"names the held motion {kind!r} in its handover, where nobody holds its controls"
    for one in spec.capabilities:
        yield from _wrong_with(one, spec)


def _unknown(owner: str, spec: Spec, **named: Iterable[str]) -> Iterator[str]:
    """Yield the commands, channels and streams that a part of the spec names and the spec does not have."""
    known = {
        "command": [c.kind for c in spec.commands], "channel": [c.name for c in spec.channels],
        "stream": [s.name for s in spec.streams],
    }  # fmt: skip
    for what, names in named.items():
        yield from (f"has no {what} {name!r}, which its {owner} names" for name in names if name not in known[what])


def _wrong_motion(kind: str, owner: str, spec: Spec) -> Iterator[str]:
    yield from _unknown(owner, spec, command=[kind])
    found = spec.command(kind)
    if found is not None and found.lane != "motion":
        yield f"names {kind!r} of the lane {found.lane!r} in its {owner}; only motions belong there"


def _wrong_with(capability: Any, spec: Spec) -> Iterator[str]:
    name = type(capability).__name__
    if isinstance(capability, Idle | Need | Programs | Tidy):
        yield from _wrong_motion(capability.kind, name, spec)
    if isinstance(capability, Setting):
        yield from _wrong_with_setting(capability)
    if isinstance(capability, Statistics):
        yield from _unknown(name, spec, channel=capability.channels(), command=capability.kinds())
        ends = _twice([code for code, _ in capability.ends])
        yield from (f"names the end {code!r} twice in its Statistics" for code in ends)
    if isinstance(capability, GoodWhile):
        yield from _wrong_with_good_while(capability, spec)
    if isinstance(capability, JobCheck | JobChoices | Objects | Preview) and capability.stream:
        yield from _unknown(name, spec, stream=[capability.stream])
    if isinstance(capability, JobChoices):
        yield from _unknown(name, spec, command=[capability.kind])
    if isinstance(capability, JobMovies):
        yield from _unknown(name, spec, command=capability.kinds)
    if isinstance(capability, Need):
        yield from _unknown(name, spec, channel=[capability.channel])
        if not capability.below <= capability.until:
            yield f"has a Need that begins below {capability.below:g} and ends at {capability.until:g}, which is less"


def _wrong_with_good_while(good: GoodWhile, spec: Spec) -> Iterator[str]:
    yield from _unknown("GoodWhile", spec, command=[good.kind])
    command = spec.command(good.kind)
    if command is not None and not any(a.name == good.argument and not a.text for a in command.arguments):
        yield f"has no number {good.argument!r} in its command {good.kind!r}, which its GoodWhile names"
    yield from _unknown("GoodWhile", spec, channel=[good.channel])
    if not good.code:
        yield "gives no code for the end of jobs in its GoodWhile"


def _wrong_with_setting(setting: Setting) -> Iterator[str]:
    if setting.kind == "list":
        if not setting.check:
            yield f"has no check of the setting {setting.name!r}"
        return
    if not -inf < setting.low <= setting.high < inf:
        yield f"gives the setting {setting.name!r} no range"
    elif setting.default is not None and not setting.low <= setting.default <= setting.high:
        yield f"has a default for the setting {setting.name!r} that is out of its range"


def _wrong_in(command: CommandKind, told: set[str]) -> Iterator[str]:
    names = [a.name for a in command.arguments]
    yield from (f"names the argument {name!r} twice" for name in _twice(names))
    endless = [a.name for a in command.arguments if not -inf < a.low <= a.high < inf]
    yield from (f"gives the argument {name!r} no range" for name in endless)
    yield from (f"has a default for {n!r}, which is no argument," for n in command.default or {} if n not in names)
    if not command.limit_s > 0:
        yield "has no time limit"
    if command.held and ANYONE in command.asked_by:
        yield "may be asked for as a job, and nobody holds the controls of a job,"
    if command.steered and not (command.held and all(not a.text for a in command.arguments)):
        yield "is steered, and is not held, or takes texts,"
    if command.lane == "config":
        yield from _wrong_in_setting(command)
    yield from (f"shows {name!r}, which is no argument," for name in command.shown if name not in names)
    texts = [a.name for a in command.arguments if a.text and not a.number]
    yield from (f"shows the text {name!r} and has no number for it," for name in command.shown if name in texts)
    yield from (f"shows a value as {c!r}, which no state tells," for c in command.shown.values() if c not in told)
    yield from (f"shows {n!r} at the end of a held motion, which has none," for n in command.shown if command.held)


def _wrong_bounds(command: CommandKind, spec: "Spec", told: set[str]) -> Iterator[str]:
    turns = spec.pose is not None and any(name not in LENGTHS for name in spec.pose.coordinates)
    for bound in (command.policies.on_link_lost, command.policies.on_grant_end):
        if bound is None:
            continue
        if command.lane != "motion" or command.held:
            yield "has policies although it is held, or moves nothing"
        if not 0 < bound.seconds <= command.limit_s:
            yield f"lets it go on for {bound.seconds:g} s, which is not within its time limit,"
        yield from (f"bounds {r.name!r}, which no state tells," for r in bound.area if r.name not in told)
        if bound.setting:
            setting = next((one for one in spec.all_of(Setting) if one.name == bound.setting), None)
            if setting is None or setting.kind != "number" or not 0 <= setting.low <= setting.high <= command.limit_s:
                yield f"is bounded by {bound.setting!r}, which is no setting from 0 s to its time limit,"
        if bound.turn is not None and not turns:
            yield "bounds how fast it turns, and has no pose with an angle,"


def _wrong_in_setting(command: CommandKind) -> Iterator[str]:
    if command.moves or command.held or command.replaceable:
        yield "moves something, holds it or replaces it in the lane 'config'"
    if ANYONE in command.asked_by:
        yield "may be asked for as a job, and jobs change no settings,"
    if command.default is None:
        if command.asked_by - {STAFF}:
            yield "has no default that handover could restore"
        return
    for argument in command.arguments:
        value = command.default.get(argument.name)
        if value is None and argument.required:
            yield f"has no default for the argument {argument.name!r}"
        elif isinstance(value, int | float) and not argument.low <= value <= argument.high:
            yield f"has a default for {argument.name!r} that is out of its range"


def _twice(names: list[str]) -> list[str]:
    return [name for name, times in Counter(names).items() if times > 1]
