"""The words on the page of a job: the request, every stage of every run, its progress, and the result."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from django.utils.translation import gettext

from queueing.models import Job
from robots.grants import INTERRUPTED
from robots.kit.contract.capabilities import JobChoices
from robots.kit.contract.spec import Argument, Spec
from robots.kit.contract.words import way
from robots.models import Command
from robots.sentences import in_digits, translate
from robots.states import CommandState

UNDER_WAY = "Under way"


@dataclass(frozen=True)
class Stage:
    """One stage of a run: its name, when it was reached, and a note."""

    words: str
    at: datetime
    note: str = ""


def request_in_words(job: Job, texts: bool) -> list[tuple[str, str]]:
    """Return the name and value of each argument, with its unit if the robot still takes such jobs.

    What has words for its directions needs no name: "33 cm down from where its map began". `texts`: also texts that
    people wrote, which only the asker and staff see.
    """
    units, labels, ways = _units(job), _labels(job), _ways(job)
    return [
        ("", translate(ways[name])) if name in ways else (labels.get(name, name), value)
        for name, value in _valued(_shown(job.args, labels), units, texts)
    ]


def stages(command: Command) -> list[Stage]:
    """Return the stages that a command has reached, in the order of time, and its newest progress among them."""
    stamped = (
        (CommandState.QUEUED, command.created_at), (CommandState.ACCEPTED, command.accepted_at),
        (CommandState.SENT, command.sent_at), (CommandState.ACKNOWLEDGED, command.acknowledged_at),
    )  # fmt: skip
    found = [Stage(str(state.label), at) for state, at in stamped if at is not None]
    if said := _progress(command):
        found.append(Stage(UNDER_WAY, _told_at(command) or found[-1].at, said))
    if command.ended_at is not None:
        cut = command.reason.startswith(INTERRUPTED)
        name = INTERRUPTED if cut else command.get_state_display()
        found.append(Stage(name, command.ended_at, translate(command.reason)))
    return found


def share_of(command: Command | None) -> float | None:
    """Return how much of a command that runs is done, from 0 to 1; None where the robot does not say."""
    share = command.progress.get("share") if command is not None and not command.final else None
    return share if isinstance(share, int | float) else None


def result(job: Job, command: Command | None, texts: bool) -> list[tuple[str, str]]:
    """Return name and value of each part of the last command's result; nothing before its end.

    First the values that were really sent, then the channels at its end, then the words about its picture.
    """
    if command is None or not command.final:
        return []
    told, units, labels = command.result, _units(job), _labels(job)
    found = [
        (labels.get(name, name), value)
        for name, value in _valued(_shown(_object(told.get("sent")), labels), units, texts)
    ]
    measured = _object(_object(told.get("channels")).get("ended"))
    found += [
        (gettext("%(name)s at its end") % {"name": translate(name)}, value)
        for name, value in _valued(measured, units, texts)
    ]
    return found + [
        (name, translate(told[key]))
        for name, key in ((gettext("ended"), "ended"), (gettext("picture"), "verdict"))
        if told.get(key)
    ]


def _progress(command: Command) -> str:
    told, share = command.progress, command.progress.get("share")
    much = f" ({share:.0%})".replace("%", " %") if isinstance(share, int | float) else ""
    return f"{translate(told.get('text') or '')}{much}".strip()


def _told_at(command: Command) -> datetime | None:
    at_ms = command.progress.get("at_ms")
    return datetime.fromtimestamp(at_ms / 1000, UTC) if isinstance(at_ms, int | float) else None


def _spec_of(job: Job) -> tuple[Spec | None, tuple[Argument, ...]]:
    """Return the robot's spec and the arguments of the job's kind; nothing if the robot's package is not installed."""
    try:
        spec = job.robot.spec()
    except LookupError:
        return None, ()
    kind = spec.command(job.kind)
    return spec, tuple(kind.arguments) if kind else ()


def _units(job: Job) -> dict[str, str]:
    """Return the unit of each argument and channel."""
    spec, arguments = _spec_of(job)
    channels = spec.channels if spec is not None else ()
    return {one.name: one.unit for one in channels} | {one.name: one.unit for one in arguments}


def _labels(job: Job) -> dict[str, str]:
    """Return the label of each argument, and the robot's plain word for any other value that it tells.

    It is empty for the robot's own numbers, where people choose by words.
    """
    spec, arguments = _spec_of(job)
    by_words = spec is not None and any(one.kind == job.kind for one in spec.all_of(JobChoices))
    named = {one.name: "" if by_words and one.whole else one.label or one.name for one in arguments}
    return {**(spec.words if spec is not None else {}), **named}


def _shown(values: Mapping[str, Any], labels: Mapping[str, str]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if labels.get(name) != ""}


def _ways(job: Job) -> dict[str, str]:
    """Return in words, by name, the arguments that lie in a direction."""
    directed = (one for one in _spec_of(job)[1] if one.directions and one.unit)
    found = {one.name: way(one.directions, job.args[one.name], one.unit) for one in directed if one.name in job.args}
    return {name: words for name, words in found.items() if words}


def _valued(values: Mapping[str, Any], units: Mapping[str, str], texts: bool) -> Iterator[tuple[str, str]]:
    for name, value in values.items():
        if isinstance(value, int | float):
            yield name, f"{in_digits(value)} {units.get(name, '')}".strip()
        elif texts or not isinstance(value, str):
            yield name, str(value)


def _object(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}
