"""Checks of a motion whose controls are steered: the driver asks for the newest values, and follows them."""

from collections.abc import Iterator
from functools import partial

from robots.kit.conformance.motions import Motions, motions_of, underway
from robots.kit.conformance.report import NotApplicable, Note
from robots.kit.conformance.runs import command_text, denial, error_text
from robots.kit.conformance.trial import Trial
from robots.kit.contract.session import JSON, RobotState
from robots.kit.contract.spec import CommandKind

PERMITS = 5  # asked for in a motion without asking for its controls: they are not asked again
SLOWER = 0.5  # share of a velocity along what it was before: less of it, and the motion is another one


def steered(trial: Trial) -> Iterator[str]:
    """A steered motion asks for the newest values again and again, and follows them."""
    trial.ready_session()
    kinds = [(c, listed) for c in trial.motions() if c.steered and len(listed := motions_of(trial, c)) > 1]
    if not kinds:
        raise NotApplicable("no kind of command is steered")
    for command, listed in kinds:
        trial.settle()
        session, newest, asked = trial.opened_session(), dict[str, float](), list[int]()

        def ask(newest: JSON = newest, calls: list[int] = asked) -> JSON:
            calls.append(1)
            return dict(newest)

        session.on_steered = ask
        try:
            yield from _steered(trial, command, listed, newest, asked)
        finally:
            session.on_steered = None


def _steered(
    trial: Trial, command: CommandKind, listed: Motions, newest: dict[str, float], asked: list[int]
) -> Iterator[str]:
    run = underway(trial, listed)
    if run is None:
        yield Note(f"The steered motion {command.kind!r} was not seen moving.")
        return
    what, session = command_text(run.kind, run.args), trial.opened_session()
    before = _velocities(session.state())
    newest.update(max((args for _, args in listed), key=partial(_difference, run.args)))
    count, permits = len(asked), run.permits
    trial.poll(
        lambda: len(asked) > count or run.permits > permits + PERMITS or run.over.is_set(), trial.limits.answer_s
    )
    if len(asked) == count:
        yield f"{what} does not call steered() while it moves; ask for the newest values again and again."
    elif not any(before):
        yield Note(f"The states of {command.kind!r} tell no velocity; whether it follows newer values was not seen.")
    elif not trial.poll(lambda: run.over.is_set() or _is_other(before, session.state()), trial.limits.answer_s):
        yield (
            f"{what} goes on as it began after newer values had come ({command_text(run.kind, newest)}); "
            "follow the newest."
        )
    elif run.over.is_set():
        yield f"{what} ended with {error_text(run.error)} when newer values came; follow them."
    run.refuse = denial()
    run.ends(trial.limits.answer_s)


def _difference(one: JSON, other: JSON) -> float:
    return sum(abs(float(one[name]) - float(other[name])) for name in one if name in other)


def _velocities(state: RobotState) -> tuple[float, ...]:
    return *state.velocities, *state.twist


def _is_other(before: tuple[float, ...], state: RobotState) -> bool:
    along = sum(a * b for a, b in zip(before, _velocities(state), strict=False))
    return state.moving and along < SLOWER * sum(a * a for a in before)
