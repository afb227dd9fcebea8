"""The verbs of the register of finds: report a find, decide on it, hide the pieces again."""

from dataclasses import dataclass
from datetime import datetime
from math import isfinite
from typing import Any

from django.db import IntegrityError, transaction
from django.utils.translation import gettext

from operatorlog.errors import LogError
from operatorlog.models import Find, Piece, Round
from queueing.models import Turn
from robots import services as robot_services
from robots.kit.contract.errors import BadRequest, NotPermitted
from robots.kit.contract.excavation import Excavation
from robots.kit.contract.find import function, spec_or_none
from robots.kit.contract.words import place_of
from robots.kit.plain import one_line, storable
from robots.models import Command, Frame, Robot
from robots.people import is_person
from robots.states import COMMAND_FINAL, CommandState, GrantKind

LONGEST_NAME, LONGEST_PUZZLE = 80, 300
MOST_PIECES = 100
MOST_OF_A_TURN = 12  # reports


@dataclass(frozen=True)
class Report:
    """What an operator fills in: a name, one picture of the turn, and a place (m); without one, the picture's."""

    name: str
    frame: int | None = None
    x: float | None = None
    y: float | None = None


@dataclass(frozen=True)
class NextRound:
    """What staff say of the next round: its puzzle, and the names of the pieces, of a real robot alone."""

    puzzle: str
    pieces: tuple[str, ...] = ()


def excavation_of(robot: Robot) -> Excavation | None:
    """Return what the robot's spec says about hidden pieces; None for a robot that has none, or is for practice."""
    if robot.practice:
        return None
    spec = spec_or_none(robot.driver)
    return spec.capability(Excavation) if spec else None


def present_round(robot: Robot) -> Round | None:
    """Return the round that goes on; None before the first."""
    return Round.objects.filter(robot=robot, ended_at=None).first()


def begin_first(robot: Robot, now: datetime, user: Any = None) -> Round | None:
    """Return the present round; the first begins with the robot. None for a robot without hidden pieces."""
    declared = excavation_of(robot)
    if declared is None:
        return None
    present = present_round(robot)
    if present is not None or Round.objects.filter(robot=robot).exists():
        return present
    first = robot.grants.order_by("opened_at").first()
    try:
        with transaction.atomic():
            made = Round.objects.create(
                robot=robot, number=1, began_at=first.opened_at if first else now, begun_by=user,
                puzzle=declared.puzzle if robot.simulated else "",
            )  # fmt: skip
            _hide(made, declared)
    except IntegrityError:  # another request was faster
        return present_round(robot)
    return made


def _hide(made: Round, declared: Excavation) -> None:
    """Store the pieces of the simulated bed with the round's number; of a real robot staff fill them in."""
    if declared.pieces and made.robot.simulated:
        hidden = function(declared.pieces)(made.robot.rig_secret, made.number)
        Piece.objects.bulk_create(Piece(round=made, name=one.name, x=one.x, y=one.y) for one in hidden)


def report(turn: Turn, user: Any, filled_in: Report, now: datetime) -> Find:
    """Store what the operator of an ended turn has found, for a moderator. Raises LogError."""
    if not is_person(user, turn.user_id):
        raise LogError(gettext("Only the operator of a turn can report what was found in it."))
    if turn.ended_at is None:
        raise LogError(gettext("The turn is still running; report when it has ended."))
    declared = excavation_of(turn.robot)
    if declared is None:
        raise LogError(gettext("With this robot nothing is hidden."))
    name = one_line(filled_in.name)
    if not name or not storable(filled_in.name):
        raise LogError(gettext("Say in a few words what you have found."))
    if len(name) > LONGEST_NAME:
        said = gettext("Say what you have found in at most {most} characters; yours are {count}.")
        raise LogError(said.format(most=LONGEST_NAME, count=len(name)))
    frame = (
        Frame.objects.filter(pk=filled_in.frame, grant=turn.grant_id).first() if filled_in.frame is not None else None
    )
    if filled_in.frame is not None and frame is None:
        raise LogError(gettext("Choose a picture of your own turn."))
    x, y = _place(turn.robot, declared, filled_in, frame)
    begin_first(turn.robot, now)
    known = Round.objects.filter(robot=turn.robot)
    of_turn = known.filter(began_at__lte=turn.started_at).order_by("-number").first()
    of_turn = of_turn or known.order_by("number").first()
    if of_turn is None:
        raise LogError(gettext("Nothing is hidden yet."))
    with transaction.atomic():
        Turn.objects.select_for_update().get(pk=turn.pk)
        earlier = Find.objects.filter(turn=turn)
        same = earlier.filter(name=name, frame=frame, x=x, y=y).first()
        if same is not None:
            return same  # a double press
        if earlier.count() >= MOST_OF_A_TURN:
            said = gettext("You have reported {most} finds of this turn; more are not taken.")
            raise LogError(said.format(most=MOST_OF_A_TURN))
        made = Find.objects.create(
            round=of_turn, turn=turn, author=user, name=name, x=x, y=y, frame=frame, reported_at=now,
            seen_at=frame.taken_at if frame else turn.ended_at,
        )  # fmt: skip
        if frame is not None:
            Frame.objects.filter(pk=frame.pk).update(kept=True)
    return made


def _place(robot: Robot, declared: Excavation, filled_in: Report, frame: Frame | None) -> tuple[float, float]:
    shown = place_of(robot.spec(), frame.pose) if frame else {}
    x, y = (
        (shown.get("x") if filled_in.x is None else filled_in.x),
        (shown.get("y") if filled_in.y is None else filled_in.y),
    )
    if x is None or y is None or not (isfinite(x) and isfinite(y)):
        raise LogError(gettext("Choose the picture that shows what you have found, or give its place in numbers."))
    x0, y0, x1, y1 = declared.area
    if not (x0 <= x <= x1 and y0 <= y <= y1):
        said = gettext(
            "The place of a find lies in the area of the map: from {left} to {right} cm across, "
            "from {low} to {high} cm along."
        )
        named = zip(("left", "low", "right", "high"), declared.area, strict=True)
        raise LogError(said.format(**{name: f"{100 * value:g}" for name, value in named}))
    return round(x, 4), round(y, 4)


def decide(find: Find, user: Any, state: Find.State, piece: Piece | None, now: datetime) -> bool:
    """Confirm a find as a piece of its round, or decline it. Return whether that changed it. Raises LogError."""
    if not user.has_perm("operatorlog.change_find"):
        raise LogError(gettext("This is for moderators."))
    piece = check_decision(find, state, piece)
    with transaction.atomic():
        row = Find.objects.select_for_update().get(pk=find.pk)
        changed = (row.state, row.piece_id) != (state, piece.pk if piece else None)
        row.state, row.piece = state, piece
        row.decided_by, row.decided_at = user, now
        row.save(update_fields=["state", "piece", "decided_by", "decided_at"])
    return changed


def check_decision(find: Find, state: Find.State, piece: Piece | None) -> Piece | None:
    """Return the piece that is stored with a decision. Raises LogError."""
    if state != Find.State.CONFIRMED:
        return None
    if piece is None:
        raise LogError(gettext("Choose which piece it is."))
    if piece.round_id != find.round_id:
        raise LogError(gettext("Choose a piece of {round}, in which it was found.").format(round=find.round))
    return piece


def bury_again(ending: Round, user: Any, upcoming: NextRound, now: datetime) -> bool:
    """End the present round and begin the next, with its own puzzle and pieces; the old one becomes a milestone.

    A simulated robot's bed is made anew by a command. Of a real robot staff hide the pieces, then fill in where. Return
    False, and change nothing, where the round had ended before, as after a second press.

    Raises:
        RobotError: not permitted; puzzle or pieces are missing; the robot is in use, or no command reaches it.
    """
    if not user.has_perm("operatorlog.renew_round"):
        raise NotPermitted(gettext("This is for staff who may hide the pieces again."))
    with transaction.atomic():
        robot = Robot.objects.select_for_update().get(pk=ending.robot_id)
        present = Round.objects.select_for_update().get(pk=ending.pk)
        if present.ended_at is not None or present.command_id != ending.command_id:
            return False  # somebody else was faster
        declared = excavation_of(robot)
        if declared is None:
            raise BadRequest(gettext("With this robot nothing is hidden."))
        if present.command is not None and present.command.state not in COMMAND_FINAL:
            return False
        puzzle, pieces = _checked(upcoming, robot)
        if was_not_made(present):
            present.command = _renewed(robot, declared, user, present.number, now)
            present.puzzle = puzzle
            present.save(update_fields=["command", "puzzle"])
            present.pieces.all().delete()
            _hide(present, declared)
            return True
        command = _renewed(robot, declared, user, present.number + 1, now)
        present.ended_at = now
        present.save(update_fields=["ended_at"])
        made = Round.objects.create(
            robot=robot, number=present.number + 1, began_at=now, begun_by=user, command=command, puzzle=puzzle
        )
        if command is not None:
            _hide(made, declared)
        elif robot.simulated:  # its bed stays as it is
            Piece.objects.bulk_create(Piece(round=made, name=p.name, x=p.x, y=p.y) for p in present.pieces.all())
        else:
            Piece.objects.bulk_create(Piece(round=made, name=name) for name in pieces)  # staff fill in where
    return True


def was_not_made(one: Round) -> bool:
    """Return whether the command has failed that should have made the bed of a round."""
    command = one.command
    return command is not None and command.state in COMMAND_FINAL and command.state != CommandState.COMPLETED


def _checked(upcoming: NextRound, robot: Robot) -> tuple[str, tuple[str, ...]]:
    """Return puzzle and names of the pieces as they are stored. Raises BadRequest."""
    puzzle, names = one_line(upcoming.puzzle), tuple(name for name in map(one_line, upcoming.pieces) if name)
    if not 0 < len(puzzle) <= LONGEST_PUZZLE:
        said = gettext("Say in at most {most} characters what people are asked to find out.")
        raise BadRequest(said.format(most=LONGEST_PUZZLE))
    if robot.simulated:
        return puzzle, ()
    if not 0 < len(names) <= MOST_PIECES or max(map(len, names)) > LONGEST_NAME or len(set(names)) < len(names):
        said = gettext("Name the pieces, one to {most}, each in at most {longest} characters, and no two alike.")
        raise BadRequest(said.format(most=MOST_PIECES, longest=LONGEST_NAME))
    return puzzle, names


def _renewed(robot: Robot, declared: Excavation, user: Any, number: int, now: datetime) -> Command | None:
    """Ask a simulated robot for the bed of a number. Nobody may use it meanwhile: what they dig would vanish."""
    if not robot.simulated or not declared.renewed_by:
        return None
    grant = robot_services.open_grant(robot)
    if grant is not None and grant.kind in (GrantKind.TURN, GrantKind.JOB):
        raise NotPermitted(gettext("Somebody uses the robot; hide the pieces again when the turn or job is over."))
    return robot_services.configure(robot, user, declared.renewed_by, {"number": number}, now)
