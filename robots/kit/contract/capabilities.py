"""Capabilities of a robot beside its commands; only those that its spec declares are offered.

Functions are named by import path (`package.module:name`), so that reading a spec loads nothing heavy.
They are pure: no wire, no Django. They are called with values that people sent, so each takes at most 0.2 s of a
processor and 50 MB whatever the values are, and raises nothing but errors of `robots.kit.contract.errors`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import Any, Literal

from robots.kit.contract.objects import Box


@dataclass(frozen=True)
class Setting:
    """A value that staff may set for one robot on its page of the admin; the driver reads it from `settings` by name.

    A `number` lies between `low` and `high`, in `unit`; where it is left empty, the driver uses its own value, which
    `default` tells. A `list` is JSON: `check(value)` returns it tidied or raises BadRequest, and `editor` names the
    admin's editor for it, if there is one. Consoles are told the values of those that are `shown`.
    """

    name: str
    label: str
    kind: Literal["number", "list"] = "number"
    unit: str = ""
    low: float = -inf
    high: float = inf
    default: float | None = None
    help: str = ""
    check: str = ""
    editor: str = ""
    shown: bool = False


@dataclass(frozen=True)
class Check:
    """A robot's own check of a command, in place of the check of names, types and ranges.

    `function(kind, args, settings, state)` returns None or raises BadRequest or OutOfWorkspace. `settings`
    are those of the robot's row, `state` is its newest `RobotState`, or None where that is not known.
    """

    function: str


@dataclass(frozen=True)
class JobCheck:
    """A robot's own check of a job when somebody asks for it, by the packets of its byte stream `stream` so far.

    `function(kind, args, packets)` returns None or raises BadRequest. `packets` yields the data of each packet since
    the newest key packet, and whether it is one. It is called after the other checks, and not while the stream is not
    known: the driver judges again when the job runs.
    """

    stream: str
    function: str


@dataclass(frozen=True)
class JobChoices:
    """The jobs of that `kind` that people can ask for now, in words, by the packets of the byte stream `stream`.

    Forms offer these in place of a field for each argument. `function(packets)` gets what a `JobCheck` gets and
    returns pairs of words and arguments, in the order in which they are listed. `label` names the choice, `nothing` is
    a sentence for the case that there is none yet.
    """

    kind: str
    stream: str
    function: str
    label: str
    nothing: str


@dataclass(frozen=True)
class Preview:
    """A preview of where a command would lead, shown before it is given.

    `function(kind, args, joints, settings)` returns a `Foreseen` for the joints (rad, m) to begin with; a robot that
    has none gets its pose (m, rad) instead, or nothing where that is not known, and answers in its own frame.
    `prepare(settings)` fills caches in advance, outside the bounds of time and memory. With the name of a byte stream
    as `stream` the function gets its packets too, as `JobCheck` does: none where they are not known.
    """

    function: str
    prepare: str = ""
    stream: str = ""


@dataclass(frozen=True)
class Judgement:
    """A warning about a step before anything moves, with the time in the program (s); `refuses`: it will not run."""

    step: int
    at_s: float
    text: str
    refuses: bool = True

    @property
    def sentence(self) -> str:
        """Return it with its time, as pages show it."""
        minutes, seconds = divmod(round(self.at_s), 60)
        at = f"{minutes}:{seconds:02d}"
        return f"Will not run, after {at} min: {self.text}" if self.refuses else f"Note, after {at} min: {self.text}"


@dataclass(frozen=True)
class Foreseen:
    """The answer of a preview.

    `joints`: where it ends (rad, m). `path`: joints at points in time along the motion (rad, m).
    `tool`: the tool's position (x, y, z) in m at each point of `path`. `seconds`: how long the motion lasts.
    `steps`: the step of the program to which each point of `path` belongs, counted from 1; 0 at the start.
    `poses`: the body's poses along the motion in the robot's own frame: from where it is now, the origin, x ahead, y to
    its left, angles to the left; each with the coordinates of the spec's pose (m, rad). `times`: when it is at each
    of them (s), not falling. At most 2000. `judgements`: of its steps, in their order; the path ends at
    one that refuses.
    """

    joints: tuple[float, ...] = ()
    path: tuple[tuple[float, ...], ...] = ()
    tool: tuple[tuple[float, ...], ...] = ()
    seconds: float = 0.0
    steps: tuple[int, ...] = ()
    poses: tuple[tuple[float, ...], ...] = ()
    times: tuple[float, ...] = ()
    judgements: tuple[Judgement, ...] = ()


@dataclass(frozen=True)
class ClickInPicture:
    """A click in the newest picture is a command: consoles send it as `kind` with `still`, `u` and `v` (px).

    `resolve(picture, u, v)` returns the command's kind and arguments for a point inside a `PictureTaken`. A click
    is refused if the robot is known to be more than `apart_m` (m) or `apart_rad` (rad) from the pose of the picture.
    """

    kind: str
    resolve: str
    apart_m: float = 0.02
    apart_rad: float = 0.05


@dataclass(frozen=True)
class PictureTaken:
    """A kept picture: its size in px, where the robot was (m, rad), and the calibration of that time."""

    width: int
    height: int
    joints: tuple[float, ...]
    pose: tuple[float, ...]
    calibration: Mapping[str, Any]


@dataclass(frozen=True)
class ResultRow:
    """A value of a calibration's result that staff are shown; `path` are the keys that lead to it."""

    label: str
    path: tuple[str, ...]
    unit: str = ""

    def value(self, result: Any) -> float | str | None:
        """Return the value, or None where the result has none."""
        for key in self.path:
            result = result.get(key) if isinstance(result, Mapping) else None
        return result if isinstance(result, int | float | str) else None


@dataclass(frozen=True)
class Calibration:
    """A procedure that measures the robot; it runs before the first turn and when staff ask for it.

    `procedure(session, settle, permit)` returns the result as JSON; `settle()` returns a stable picture with its
    verdict (`robots.kit.vision.stability.Verdict`). Raises NotCalibrated and what `Session.execute` raises.
    `rows` are the values of the result that staff are shown.
    """

    procedure: str
    label: str = "Calibrate the camera"
    limit_s: float = 180.0
    rows: tuple[ResultRow, ...] = ()

    def result_rows(self, result: Mapping[str, Any]) -> tuple[tuple[str, Any, str], ...]:
        """Return label, value and unit of each row that the result has."""
        found = ((row.label, row.value(result), row.unit) for row in self.rows)
        return tuple((label, value, unit) for label, value, unit in found if value is not None)

    told = result_rows  # its name in 0.1, until 1.0


@dataclass(frozen=True)
class Reset:
    """The session has a `recover` of its own, which staff may ask for; after a fault the owner calls it by itself."""

    label: str = "Soft reset"
    limit_s: float = 60.0


@dataclass(frozen=True)
class Stills:
    """The way pictures at rest are taken: pairs at `settle_exposure_s` until two differ by less than `threshold`.

    `threshold` is in grey levels, `tries` the most pairs. The delivered picture is exposed for `exposure_s`, within
    `exposure_range_s` (s). `brightness` names a class whose `correct(picture)` returns (picture, next corrector).
    Staff may set `threshold` and `exposure_s` (`settings`). Without this capability one picture is taken and not
    judged, and the camera chooses the exposure.
    """

    settle_exposure_s: float
    threshold: float
    tries: int
    exposure_s: float
    exposure_range_s: tuple[float, float]
    brightness: str = ""

    def settings(self) -> tuple[Setting, Setting]:
        """Return what staff may set."""
        shortest, longest = self.exposure_range_s
        return (
            Setting(
                "still_threshold", "Stability threshold", unit="grey levels", low=0.01, high=255.0,
                default=self.threshold, help="Two pictures that differ by less are of a robot at rest.",
            ),
            Setting(
                "still_exposure_s", "Exposure of delivered pictures", unit="s", low=shortest, high=longest,
                default=self.exposure_s,
            ),
        )  # fmt: skip


@dataclass(frozen=True)
class ArmModel:
    """The robot is an arm that its files describe (`robots/kit/arms/described.py`): consoles and the admin draw it.

    They are `model.urdf` and the tables `arm`, `motion`, `limb` and `box` of `robot.toml`.
    """


@dataclass(frozen=True)
class Objects:
    """The robot knows objects around it; the byte stream `stream` tells where in `box` they are.

    Its packets are those of `contract/objects.py`. The robot's files describe the objects (the tables `objects` and
    `object` of `robot.toml`, `robots/kit/arms/objects.py`); consoles are told names, sizes, colours and the box.
    """

    stream: str
    box: Box


@dataclass(frozen=True)
class Programs:
    """People may save programs; the command `kind` runs one, given as `text` in a `language` of the robot's own."""

    kind: str
    language: str


@dataclass(frozen=True)
class FloorPlan:
    """The floor seen from above: movies and pages of jobs draw the robot's path over it.

    `function(settings)` returns a `Floor` (`robots.kit.contract.floor`) in the frame of the pose. Without it the path
    is drawn alone.
    """

    function: str


@dataclass(frozen=True)
class JobMovies:
    """A movie is made of each finished and recorded job of these kinds, as of each program."""

    kinds: tuple[str, ...]


@dataclass(frozen=True)
class PrivacyMasks:
    """Staff may black out parts of what its cameras see, before anybody or any file gets the picture."""

    @staticmethod
    def setting() -> Setting:
        """Return what staff may set."""
        return Setting(
            "privacy_masks", "Privacy masks", "list", check="robots.kit.vision.masks:check",
            help="Parts of the pictures that nobody sees, live, stored or recorded: a list of [camera, x0, y0, x1, y1],"
            " the camera counted from 0, the corners in px of its picture from its upper left.",
        )  # fmt: skip


@dataclass(frozen=True)
class Idle:
    """The command that the robot repeats while nobody asks for anything, in slices of `slice_s` seconds."""

    kind: str
    slice_s: float = 60.0


@dataclass(frozen=True)
class Need:
    """A command that comes before everybody once the scalar `channel` falls below `below`, until it reaches `until`."""

    kind: str
    channel: str
    below: float
    until: float


@dataclass(frozen=True)
class GoodWhile:
    """A waiting job of that kind is good while its `argument` equals the value of `channel`, if it was given.

    Once the robot tells another value, such jobs end as failed, uncharged, with `text` as the reason; statistics count
    them by `code`, as jobs that the driver refuses with it. A job that runs is judged by its driver.
    """

    kind: str
    argument: str
    channel: str
    code: str
    text: str


@dataclass(frozen=True)
class Composite:
    """One drawn picture of all that the robot shows, as motion JPEG for other software and browsers without scripts.

    `name` is part of its address, `width` and `height` are in px. `scene` names a class of `Scene`s
    (`robots.kit.contract.composites`), which is called with `width` and `height`.
    """

    name: str
    width: int
    height: int
    scene: str


@dataclass(frozen=True)
class Total:
    """A row of the statistics: by how much the counter `channel` has grown (m, kWh, ... by the channel's unit).

    A counter that fell has begun anew, so its value then counts in full.
    """

    label: str
    channel: str


@dataclass(frozen=True)
class Times:
    """A row of the statistics: how many commands of that kind were completed, or, with `failed`, failed."""

    label: str
    kind: str
    failed: bool = False


@dataclass(frozen=True)
class Share:
    """A row of the statistics: the share of the time during which commands of these kinds ran."""

    label: str
    kinds: tuple[str, ...]


@dataclass(frozen=True)
class Statistics:
    """The content of a robot's page of statistics beside its jobs, which every robot that takes jobs has there.

    The owner stores the values of the named channels with each motion, at its beginning and at its end. `ends`: codes
    of the errors with which the driver refuses a job for a reason of its own, and the label of the row in which such
    jobs are counted; they were never attempted. `against`: the channel against whose value at the beginning of a job
    the success of jobs is drawn. `over_time`: the channel that is drawn over the hours. `job`, `done`: what the robot
    calls a job, and one that is done.
    """

    rows: tuple[Total | Times | Share, ...] = ()
    ends: tuple[tuple[str, str], ...] = ()
    against: str = ""
    over_time: str = ""
    job: str = "job"
    done: str = "done"

    def channels(self) -> tuple[str, ...]:
        """Return the channels whose values are stored with each motion."""
        counters = (row.channel for row in self.rows if isinstance(row, Total))
        return tuple(dict.fromkeys(name for name in (*counters, self.against, self.over_time) if name))

    def kinds(self) -> tuple[str, ...]:
        """Return the kinds of commands that its rows name."""
        named = (
            row.kinds if isinstance(row, Share) else (row.kind,) for row in self.rows if not isinstance(row, Total)
        )
        return tuple(dict.fromkeys(kind for kinds in named for kind in kinds))
