"""Motions that last long enough for something to happen in them."""

from itertools import cycle

from robots.kit.conformance.report import NotApplicable
from robots.kit.conformance.runs import Run
from robots.kit.conformance.trial import ENDLESS, Trial
from robots.kit.conformance.values import good
from robots.kit.contract.capabilities import Need
from robots.kit.contract.session import JSON
from robots.kit.contract.spec import CommandKind

TRIES = 5  # how often a motion is begun until it lasts long enough
Motions = list[tuple[str, JSON]]


def motions_of(trial: Trial, command: CommandKind) -> Motions:
    """Return commands of one kind that each lead somewhere else."""
    return [(command.kind, args) for args in good(trial, command)]


def longest(trial: Trial, but: str = "") -> Motions:
    """Return commands of the kind that was seen moving for the longest time, one after another. Raises NotApplicable.

    `but`: a kind that does not count.

    A kind with a single target does not count, unless it goes on by itself, as a patrol does. A kind that a robot needs
    now and then, as to recharge, comes last: it ends at once if it was done before.
    """
    needed = {need.kind for need in trial.spec.all_of(Need)}
    found: list[tuple[bool, float, Motions]] = []
    for command in trial.motions():
        listed = [] if command.held or command.kind == but else motions_of(trial, command)
        moved = trial.moved.get(command.kind, 0.0)
        if listed and (len(listed) > 1 or moved > ENDLESS or not trial.moved):
            found.append((command.kind not in needed, moved, listed))
    for _, _, listed in sorted(found, key=lambda one: one[:2], reverse=True):
        if underway(trial, listed) is not None:
            trial.settle()
            return listed
    raise NotApplicable("no kind moves the robot from one place to another; give examples of values in robot.toml")


def underway(trial: Trial, listed: Motions, looks: int = 1) -> Run | None:
    """Begin a motion of the list and return it once it was seen moving so many times; None where none lasts so long.

    The list is rotated, so that the next motion leads somewhere else.
    """
    for kind, args in _turned(listed):
        run, seen = trial.run(kind, args), 0
        for state in trial.looks(run, trial.limits.answer_s):
            seen += state.moving and run.acknowledged.is_set()
            if seen >= looks:
                return run
        trial.settle()
    return None


def _turned(listed: Motions) -> Motions:
    """Return the next motions, and rotate the list so that another one comes first the next time."""
    turns, found = cycle(range(len(listed))), []
    for _ in range(max(TRIES, len(listed))):
        next(turns)
        listed.append(listed.pop(0))
        found.append(listed[-1])
    return found
