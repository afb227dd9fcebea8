"""Checks of a robot that goes on without messages: for how long (`time_left`), and when it rests (`rests_within`)."""

from collections.abc import Iterator
from math import isfinite

from robots.kit.conformance.lines import SILENT, board_of
from robots.kit.conformance.motions import Motions, longest, motions_of, underway
from robots.kit.conformance.report import NotApplicable, Note
from robots.kit.conformance.runs import Run, command_text, error_text
from robots.kit.conformance.trial import PAUSE_S, Trial
from robots.kit.contract.spec import CommandKind


def time_left(trial: Trial) -> Iterator[str]:
    """A motion that may go on without messages ends before the time of its command is over."""
    trial.ready_session()
    bounds = [(c, bound, motions_of(trial, c)) for c in trial.motions() if (bound := c.policies.on_link_lost)]
    kinds = [(c, bound.seconds / 2, listed) for c, bound, listed in bounds if listed]
    if not kinds:
        raise NotApplicable("no kind goes on where the link is lost")
    for command, left, listed in kinds:
        trial.settle()
        session = trial.opened_session()
        session.on_time_left = lambda left=left: left  # type: ignore[misc]
        try:
            yield from _within(trial, command, listed, left)
        finally:
            session.on_time_left = None


def _within(trial: Trial, command: CommandKind, listed: Motions, left: float) -> Iterator[str]:
    """Check how long the robot may go on where time_left() always returns `left` (s)."""
    run = underway(trial, listed)
    if run is None:
        yield Note(f"No motion of the kind {command.kind!r} was seen.")
        return
    alone = False
    for _ in trial.looks(run, trial.limits.watch_s):
        within = trial.opened_session().rests_within()
        alone = alone or within is not None
        if within is not None and within > max(left, trial.spec.rest_s or 0.0):
            yield (
                f"{command_text(run.kind, run.args)} may move for {left:g} s more, and without a word the robot would "
                f"rest within {within:.1f} s only; let what it goes on by end before time_left() does."
            )
            return
    if not alone:
        yield Note(f"The robot was not allowed to go on by itself in {command.kind!r}; its time was not seen.")


def rests_within(trial: Trial) -> Iterator[str]:
    """A robot that no message reaches rests within the time that `rests_within` returned, in motion and at rest."""
    board = board_of(trial)
    if board.moving() is None:
        raise NotApplicable("the simulator does not tell whether its robot moves")
    if trial.spec.rest_s is None:
        raise NotApplicable("the spec does not say within how many seconds the robot rests by itself (rest_s)")
    trial.ready_session()
    alone = [motions_of(trial, c) for c in trial.motions() if c.policies.on_link_lost]
    for listed in (longest(trial), *filter(None, alone)):
        trial.settle()
        if (run := underway(trial, listed)) is not None:
            yield from _rests(trial, run, trial.spec.rest_s)
        trial.settle()
        within = trial.opened_session().rests_within()
        if within is not None and not 0.0 <= within <= trial.spec.rest_s:
            yield f"rests_within() says {within!r} of a robot at rest; return None, or at most its rest_s."


def _rests(trial: Trial, run: Run, rest_s: float) -> Iterator[str]:
    """Cut the line of a motion, and wait until its simulator says that the robot rests."""
    board, session, what = board_of(trial), trial.opened_session(), command_text(run.kind, run.args)
    found = trial.spec.command(run.kind)
    if found is not None and found.policies.on_link_lost:
        trial.poll(lambda: session.rests_within() is not None or run.over.is_set(), trial.limits.watch_s)
    if not any([board.set(verb) for verb in SILENT]):
        raise NotApplicable(f"no fault of the simulator makes it silent ({', '.join(SILENT)})")
    call = trial.call(session.rests_within, "rests_within")
    if not call.ends(trial.limits.answer_s) or call.error is not None:
        yield f"rests_within() in {what} answers {error_text(call.error)} on a silent line; it asks memory only."
        return
    told = rest_s if call.value is None else call.value
    most = trial.spec.rests_within(run.kind, session.settings) or rest_s
    if not isinstance(told, int | float) or not isfinite(told) or told < 0.0:
        yield f"rests_within() in {what} returned {told!r}; return seconds, or None for the spec's rest_s."
    elif told > most + PAUSE_S:
        yield f"rests_within() says {told:.1f} s in {what}; the spec says {most:g} s at most (rest_s and its policy)."
    elif not trial.poll(lambda: board.moving() is False, told + trial.limits.watch_s):
        yield f"No word reached the robot in {what}, and it still moves long after the {told:.1f} s of rests_within()."
