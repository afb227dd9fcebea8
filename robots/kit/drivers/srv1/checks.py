"""What the rover refuses beside the ranges of the spec: a place where it cannot stand, rules that cannot brake."""

from robots.kit.contract.find import spec_of
from robots.kit.contract.session import JSON, RobotState
from robots.kit.contract.spec import Spec
from robots.kit.contract.values import known_command, number, within
from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.missions import Pose, judge, parse, refuse
from robots.kit.drivers.srv1.rules import rules_of
from robots.kit.drivers.srv1.ways import way


def check(kind: str, args: JSON, settings: JSON, state: RobotState | None) -> None:
    """Raise BadRequest or OutOfWorkspace where a command cannot be carried out from where the rover is."""
    within(known_command(described(), kind, args), args)
    here = pose_of(state)
    if kind == "go":
        way((here[0], here[1]), (number(args, "x"), number(args, "y")))
    elif kind == "mission":
        refuse(judge(parse(str(args["text"])), here)[1])
    elif kind == "rules":
        rules_of(str(args["text"]))


def described() -> Spec:
    """Return the rover's spec."""
    return spec_of("srv1")


def pose_of(state: RobotState | None) -> Pose:
    """Return where the rover is (m, m, rad); at home where that is not known."""
    if state is None or len(state.pose) != 3:
        return hall().home
    return state.pose[0], state.pose[1], state.pose[2]
