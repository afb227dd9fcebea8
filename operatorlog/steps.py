"""The steps of a turn for its page: each command in words, its outcome, and the picture after it.

Held motions of one kind that follow each other, as jogs do, are one step. A page reads a bounded number of rows.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import groupby
from typing import Any

from django.core.paginator import Page, Paginator
from django.utils.translation import gettext

from queueing.models import Turn
from robots.kit.contract.spec import Spec
from robots.kit.contract.words import Place, command_words, place_of, way_words
from robots.models import Command, Frame, Robot
from robots.sentences import translate
from robots.states import CommandState, Lane

ON_A_PAGE = 24
MOST = 5000  # commands, and pictures, of a turn that are read
UNDONE = frozenset({CommandState.REJECTED, CommandState.EXPIRED})  # it did not begin


@dataclass(frozen=True)
class Step:
    """One command, or several held ones of a kind, from `first` to `last`; `frame` is the picture after it."""

    number: int
    first: Command
    last: Command
    count: int
    words: str
    outcome: str
    frame: Frame | None

    @property
    def begins_at(self) -> datetime:
        """Return when it began, as far as it did; else when it was asked for."""
        return self.first.sent_at or self.first.created_at

    @property
    def bad(self) -> bool:
        """Return whether it ended otherwise than completed."""
        return self.last.final and self.last.state != CommandState.COMPLETED


@dataclass(frozen=True)
class _Picture:
    """What is read of each picture of a turn: row, command, time, pose, whether a command noted it on its way."""

    pk: int
    command: int | None
    at: datetime
    pose: Any
    noted: bool


def steps_of(turn: Turn, page: Any) -> tuple[list[Step], Page[list[int]]]:
    """Return the steps on a page of a turn, in their order, and the page: its number, and which others there are."""
    spec = _spec(turn.robot)
    held = {c.kind for c in spec.commands if c.held} if spec else set()
    rows = turn.grant.commands.order_by("id").values_list("pk", "kind")[:MOST]
    groups: list[list[int]] = []
    for kind, same in groupby(rows, lambda row: row[1]):
        ids = [pk for pk, _ in same]
        groups += [ids] if kind in held else [[pk] for pk in ids]
    shown = Paginator(groups, ON_A_PAGE).get_page(page)
    return _steps(turn, spec, groups, list(shown.object_list), shown.start_index()), shown


def _spec(robot: Robot) -> Spec | None:
    try:
        return robot.spec()
    except LookupError:
        return None


def _steps(
    turn: Turn, spec: Spec | None, groups: Sequence[Sequence[int]], shown: Sequence[Sequence[int]], number: int
) -> list[Step]:
    if not shown:
        return []
    after = next((ids[0] for ids in groups if ids[0] > shown[-1][-1]), None)
    wanted = Command.objects.in_bulk({*(pk for ids in shown for pk in (ids[0], ids[-1])), *([after] if after else [])})
    counted = _outcomes(pk for ids in shown if len(ids) > 1 for pk in ids)
    pictures = _pictures(turn)
    taken = [_after(wanted[ids[-1]], ids, pictures, _next(wanted, shown, at, after)) for at, ids in enumerate(shown)]
    frames = Frame.objects.select_related("robot").in_bulk([one.pk for one in taken if one])
    place = _place_before(turn, spec, wanted[shown[0][0]], pictures) if spec else {}
    made = []
    for at, (ids, picture) in enumerate(zip(shown, taken, strict=True)):
        first, last = wanted[ids[0]], wanted[ids[-1]]
        there = _place_after(spec, last, picture, place) if spec else {}
        words = _words(spec, first, len(ids), place, there)
        outcome = _outcome(last, [counted[pk] for pk in ids] if len(ids) > 1 else [])
        frame = frames.get(picture.pk) if picture else None
        made.append(Step(number + at, first, last, len(ids), words, outcome, frame))
        place = there
    return made


def _pictures(turn: Turn) -> list[_Picture]:
    rows = turn.grant.frames.order_by("id").values_list("pk", "command_id", "taken_at", "pose", "findings")[:MOST]
    return [_Picture(pk, command, at, pose, noted is not None) for pk, command, at, pose, noted in rows]


def _outcomes(ids: Iterable[int]) -> dict[int, str]:
    return dict(Command.objects.filter(pk__in=list(ids)[:MOST]).values_list("pk", "state"))


def _next(wanted: dict[int, Command], shown: Sequence[Sequence[int]], at: int, after: int | None) -> Command | None:
    following = shown[at + 1][0] if at + 1 < len(shown) else after
    return wanted.get(following) if following is not None else None


def _after(
    last: Command, ids: Sequence[int], pictures: Sequence[_Picture], following: Command | None
) -> _Picture | None:
    """Return the picture that shows what a step did: its own, else the first one after its end and before the next."""
    own = [one for one in pictures if one.command == last.pk]
    still = [one for one in own if not one.noted]
    if own:
        return (still or own)[-1]
    if last.ended_at is None or last.accepted_at is None:
        return None
    until = (following.accepted_at or following.created_at) if following else None
    later = (one for one in pictures if one.command is None and one.at >= last.ended_at)
    return next((one for one in later if until is None or one.at < until), None)


def _place_before(turn: Turn, spec: Spec, first: Command, pictures: Sequence[_Picture]) -> Place:
    """Return where the robot was before a command: where the newest picture shows it, if nothing moved it since."""
    earlier = [one for one in pictures if one.at < first.created_at]
    if earlier:
        at, command, pose = earlier[-1].at, earlier[-1].command, earlier[-1].pose
    else:
        before = Frame.objects.filter(robot=turn.robot_id, taken_at__lt=first.created_at).order_by("-id").first()
        if before is None:
            return {}
        at, command, pose = before.taken_at, before.command_id, before.pose
    since = Command.objects.filter(robot=turn.robot_id, lane=Lane.MOTION, ended_at__gt=at, accepted_at__isnull=False)
    return {} if since.filter(pk__lt=first.pk).exclude(pk=command or 0).exists() else place_of(spec, pose)


def _place_after(spec: Spec, last: Command, picture: _Picture | None, before: Place) -> Place:
    """Return where a command left the robot, as far as that is known."""
    kind = spec.command(last.kind)
    still = last.state in UNDONE or last.accepted_at is None or (kind is not None and not kind.moves)
    if still:
        return before
    if picture is not None:
        return place_of(spec, picture.pose)
    sent = last.result.get("sent") if last.state == CommandState.COMPLETED else None
    names = spec.pose.coordinates if spec.pose else ()
    told = {name: sent[name] for name in names if name in sent} if isinstance(sent, dict) else {}
    return place_of(spec, [told[name] for name in names]) if len(told) == len(names) else {}


def _words(spec: Spec | None, first: Command, count: int, before: Place, after: Place) -> str:
    if spec is None:
        return first.kind
    kind = spec.command(first.kind)
    if kind is None or not kind.held:
        return translate(command_words(spec, first.kind, first.args, before))
    told = {"what": translate(kind.label), "count": count, "way": translate(way_words(spec, before, after))}
    if told["way"]:
        form = gettext("{what}, {count} times: {way} in all") if count > 1 else "{what}: {way}"
        return form.format(**told)
    if count > 1:
        return gettext("{what}, {count} times").format(**told)
    return translate(command_words(spec, first.kind, first.args))


def _outcome(last: Command, states: Sequence[str]) -> str:
    """Return how a step ended, in the reader's language: its state, of several commands how many ended in which."""
    labels = dict(CommandState.choices)
    said = ", ".join(f"{labels.get(state, state)} {n}" for state, n in Counter(states).items())
    words = said if len(set(states)) > 1 else str(last.get_state_display())
    if last.clamped_words:
        words = gettext("{outcome}, with {clamped}").format(outcome=words, clamped=last.clamped_words)
    return f"{words}: {translate(last.reason)}" if last.reason else words
