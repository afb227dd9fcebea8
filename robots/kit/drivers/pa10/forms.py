"""The museum arm's letters: the values after each, and the bounds of every number."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Value:
    """A number on the wire: its name, its bounds, its unit; `whole`: an integer.

    These bounds are wider than any posture of the arm; the planner checks the arm's limits.
    """

    name: str
    low: float
    high: float
    unit: str = ""
    whole: bool = False


@dataclass(frozen=True)
class Form:
    """The values after a letter, how many of them are required, and what the line does.

    `alone`: as a line of its own; `stored`: as a line of a program.
    """

    letter: str
    values: tuple[Value, ...]
    least: int
    says: str
    alone: bool = True
    stored: bool = False
    papers: bool = False


LARGEST_EPOCH = 2**53 - 1  # every integer up to this is exact as a float
LARGEST_NUMBER = 9999
LONGEST_WAIT_S = 30
TIMES = 100
AXES = ("S1", "S2", "E1", "E2", "W1", "W2")
SPEED = Value("the share of full speed", 0.05, 1.0)
NUMBER = Value("the program's number", 0, LARGEST_NUMBER, whole=True)


def _six(names: tuple[str, ...], most: tuple[float, float], units: tuple[str, str]) -> tuple[Value, ...]:
    """Return six values: bound and unit of the first three, and of the last three."""
    return tuple(Value(name, -most[n // 3], most[n // 3], units[n // 3]) for n, name in enumerate(names))


RPY_NAMES, EULER_NAMES = ("x", "y", "z", "roll", "pitch", "yaw"), ("x", "y", "z", "phi", "theta", "psi")
TWIST_NAMES = ("vx", "vy", "vz", "wx", "wy", "wz")
PLACE_MOST, PLACE_UNITS = (2000.0, 720.0), ("mm", "deg")
JOINT_VALUES = _six(AXES, (720.0, 720.0), ("deg", "deg"))
RPY_VALUES, EULER_VALUES = (_six(names, PLACE_MOST, PLACE_UNITS) for names in (RPY_NAMES, EULER_NAMES))
CORNERS = tuple(Value(f"{name} of corner {n}", -20000.0, 20000.0, "mm") for n in (1, 2) for name in "xyz")

FORMS = {
    form.letter: form
    for form in (
        Form("j", (*JOINT_VALUES, SPEED), 6, "six joint positions in degrees; optional share of full speed",
             stored=True, papers=True),
        Form("k", (*RPY_VALUES, SPEED), 6, "x y z in mm, roll pitch yaw in degrees; optional speed",
             stored=True, papers=True),
        Form("K", (*EULER_VALUES, SPEED), 6, "x y z in mm, Euler Z-Y-Z in degrees; optional speed", stored=True),
        Form("l", (*RPY_VALUES, SPEED), 6, "as k, on a straight line of the tool", stored=True),
        Form("w", (), 0, "asks: a awaiting commands, b busy, e error", papers=True),
        Form("W", (), 0, "answers as w when the arm rests", stored=True, papers=True),
        Form("p", (NUMBER,), 1, "execute the program of that number", papers=True),
        Form("g", (Value("the gripper", 0, 1, whole=True),), 1, "gripper: 0 opens, 1 closes", stored=True, papers=True),
        Form("s", (), 0, "the whole state in one line"),
        Form("h", (), 0, "hold: come to rest now; taken at any moment"),
        Form("J", _six(AXES, (720.0, 720.0), ("deg/s", "deg/s")), 6,
             "six joint velocities in degrees/s; given again within 0.25 s or the arm rests"),
        Form("C", _six(TWIST_NAMES, (2000.0, 720.0), ("mm/s", "deg/s")), 6,
             "velocity of the tool: mm/s and degrees/s about x y z; given again as J"),
        Form("d", (Value("the wait", 0, LONGEST_WAIT_S, "s"),), 1, "in a program: wait so many seconds",
             alone=False, stored=True),
        Form("R", (Value("the number of repetitions", 1, TIMES, whole=True),), 1,
             "in a program: repeat what follows, up to E, so many times", alone=False, stored=True),
        Form("E", (), 0, "in a program: the end of a repetition", alone=False, stored=True),
        Form("u", (NUMBER,), 1, "take over a program of that number: its lines follow, a line with a dot ends it"),
        Form("b", CORNERS, 0, "a forbidden box of the staff: two corners in mm, a name; alone: takes all of them away"),
        Form("i", (Value("the epoch", 0, LARGEST_EPOCH, whole=True),), 1,
             "who asks: epoch of the owner, token if the robot needs one"),
    )
}  # fmt: skip
