"""People's programs: saving, sharing, review by staff, and the gallery."""

from datetime import datetime
from typing import Any

from django.contrib.auth import get_user_model
from django.db import IntegrityError, transaction
from django.db.models import Case, Q, QuerySet, When

from robots.kit import description
from robots.kit.contract.capabilities import Programs
from robots.kit.contract.errors import BadRequest, NotPermitted
from robots.kit.contract.find import spec_or_none
from robots.kit.plain import one_line, plain_breaks, storable
from robots.models import Program, Robot

MOST = 50  # of one person for one robot
LONGEST = 6000


def is_program(robot: Robot, kind: str) -> bool:
    """Return whether this kind of command runs a program; False if the robot's package is not installed."""
    spec = spec_or_none(robot.driver)
    return spec is not None and any(one.kind == kind for one in spec.all_of(Programs))


def stored_kind(robot: Robot, kind: str) -> str:
    """Return a kind as rows have it: empty for the robot's first language. Raises BadRequest where it runs none."""
    spec = spec_or_none(robot.driver)
    kinds = [one.kind for one in spec.all_of(Programs)] if spec is not None else []
    if kind and kind not in kinds:
        raise BadRequest("This robot has no programs of that kind.")
    return "" if kind in kinds[:1] else kind


def visible(robot: Robot, user: Any, kind: str | None = None) -> QuerySet[Program]:
    """Return the person's own programs, then those of the gallery; `user` is None for a guest.

    Those for one kind of command, or, without it, all. Raises BadRequest where that kind runs no programs.
    """
    mine = Q(author=user.pk) if user is not None and user.is_authenticated else Q(pk=None)
    found = Program.objects.filter(robot=robot).select_related("author")
    if kind is not None:
        found = found.filter(kind=stored_kind(robot, kind))
    shown = found.filter(Q(author=None, approved=True) | Q(shared=True, approved=True) | mine)
    return shown.order_by(Case(When(mine, then=0), default=1), "name", "pk")


def visible_program(robot: Robot, user: Any, pk: int, kind: str | None = None) -> Program:
    """Return a program that the person may see, for that kind of command. Raises BadRequest."""
    program = visible(robot, user, kind).filter(pk=pk).first()
    if program is None:
        raise BadRequest("There is no such program, or it is not shared.")
    return program


def load_gallery(robot: Robot, now: datetime) -> None:
    """Put the programs of the robot's package into its gallery."""
    spec = spec_or_none(robot.driver)
    folders = [one.kind for one in (spec.all_of(Programs) if spec is not None else ())]
    for folder in ("", *folders):
        kind = stored_kind(robot, folder)
        for name, text in description.programs_of(robot.driver, folder):
            Program.objects.get_or_create(
                robot=robot, author=None, name=name,
                defaults={"text": text, "approved": True, "changed_at": now, "kind": kind},
            )  # fmt: skip


def save(
    robot: Robot, user: Any, name: str, text: str, shared: bool, now: datetime, pk: int | None = None, kind: str = ""
) -> Program:
    """Save the person's own program; a changed one leaves the gallery until staff approve it again.

    Raises:
        NotPermitted: signed out, another person's program, or too many.
        BadRequest: no name, no text, a name used twice, or a kind of command that runs no programs.
    """
    if not user.is_authenticated:
        raise NotPermitted("Sign in to save programs.")
    if user.guest:
        raise NotPermitted("Sign up to save programs.")
    if not storable(name + text):
        raise BadRequest("The program contains characters that cannot be stored; use plain text.")
    name, text = one_line(name), plain_breaks(text).strip()
    if not 0 < len(name) <= 60:
        raise BadRequest("Give the program a name of at most 60 characters.")
    if not 0 < len(text) <= LONGEST:
        raise BadRequest(f"A program has at least one step, and at most {LONGEST} characters.")
    own, kind = Program.objects.filter(robot=robot, author=user.pk), stored_kind(robot, kind)
    same = own.filter(name=name, text=text, shared=shared, kind=kind)
    if pk is None and (saved := same.first()) is not None:  # a double press
        return saved
    program = own.filter(pk=pk).first() if pk is not None else Program(robot=robot, author=user, kind=kind)
    if program is None:
        raise NotPermitted("That program is not yours; save it under a name of your own.")
    if (program.name, program.text) != (name, text):
        program.approved, program.approved_by = False, None
    program.name, program.text, program.shared, program.changed_at = name, text, shared, now
    try:
        with transaction.atomic():
            # a lock on the person, because two requests at once would both be under the limit
            get_user_model().objects.select_for_update().filter(pk=user.pk).first()
            if program.pk is None and own.count() >= MOST:
                raise NotPermitted(f"You have {MOST} programs for this robot; delete one first.")
            program.save()
    except IntegrityError as error:
        if pk is None and (saved := same.first()) is not None:  # by a press at the same moment
            return saved
        raise BadRequest("You have a program of that name already.") from error
    return program


def delete(robot: Robot, user: Any, pk: int) -> None:
    """Delete the person's own program. Raises NotPermitted."""
    done, _ = Program.objects.filter(robot=robot, author=user.pk, pk=pk).delete() if user.is_authenticated else (0, {})
    if not done:
        raise NotPermitted("That program is not yours.")


def approve(program: Program, user: Any, approved: bool) -> bool:
    """Put a shared program into the gallery, or decline it or take it out. Return False if that was done before.

    Raises NotPermitted, BadRequest.
    """
    if not user.has_perm("robots.change_program"):
        raise NotPermitted("Only staff can approve programs.")
    if approved and not program.shared and program.author_id is not None:
        raise BadRequest("Its author has not shared it.")
    decided = Q(approved=True) if approved else Q(approved=False, approved_by__isnull=False)
    others = Program.objects.filter(pk=program.pk).exclude(decided)
    return bool(others.update(approved=approved, approved_by=user.pk))


def to_approve() -> QuerySet[Program]:
    """Return the programs that people share and staff have not decided on since they were changed last."""
    shared = Program.objects.filter(shared=True, approved=False, approved_by=None)
    return shared.exclude(author=None)
