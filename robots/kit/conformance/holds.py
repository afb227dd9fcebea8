"""Checks of `hold`: at any moment, from any thread, it ends the motion for good and the robot rests."""

from collections.abc import Callable, Iterator
from functools import partial

from robots.kit.conformance.commands import STILL
from robots.kit.conformance.motions import TRIES, Motions, longest, motions_of, underway
from robots.kit.conformance.report import NotApplicable, Note
from robots.kit.conformance.runs import ACKNOWLEDGED, SENT, Call, Run, command_text, denial, error_text
from robots.kit.conformance.trial import Trial, apart
from robots.kit.contract.errors import MotionHeld, MotionReplaced
from robots.kit.contract.session import RobotState

INSTANTS = (1, 3, 8)  # moving states that are seen before the robot is held
REST_LOOKS, REST_S = 4, 0.1


def hold(trial: Trial) -> Iterator[str]:
    """Before, during and after a motion; while a stage is told; twice; from two threads at once."""
    session, listed = trial.ready_session(), longest(trial)
    moments: tuple[Callable[[], Iterator[str]], ...] = (
        lambda: _held(trial, trial.call(session.hold, "hold"), "at rest"),
        *(partial(_at_stage, trial, listed, stage) for stage in (SENT, ACKNOWLEDGED)),
        *(partial(_on_the_way, trial, listed, looks, 1) for looks in INSTANTS),
        partial(_on_the_way, trial, listed, 1, 2),
        *(partial(_at_stage, trial, held, SENT) for held in _of_held_kinds(trial)),
        *(partial(_after, trial, when) for when in ("after a motion", "a second time")),
        partial(_not_in_force, trial, listed),
    )
    for moment in moments:
        words = list(moment())
        yield from words
        if any(not isinstance(word, Note) for word in words):
            return


def _of_held_kinds(trial: Trial) -> list[Motions]:
    return [listed for c in trial.motions() if c.held and (listed := motions_of(trial, c))]


def _after(trial: Trial, when: str) -> Iterator[str]:
    yield from _held(trial, trial.call(trial.ready_session().hold, "hold"), when)


def _not_in_force(trial: Trial, listed: Motions) -> Iterator[str]:
    """Begin a motion after a hold."""
    run = trial.run(*listed[0])
    if not trial.poll(run.has_begun, trial.limits.answer_s) or (run.error and not run.acknowledged.is_set()):
        yield f"A motion after a hold ended with {error_text(run.error)}; a hold must not stay in force."


def _at_stage(trial: Trial, listed: Motions, stage: str) -> Iterator[str]:
    """Hold while `on_stage` has not returned, which may take as long as a database takes."""
    calls: list[Call] = []
    words, session = f'while on_stage("{stage}") is told', trial.opened_session()

    def holds() -> None:
        calls.append(trial.call(session.hold, "hold"))
        calls[0].ends(trial.limits.answer_s)

    def begin() -> Run | None:
        calls.clear()
        kind, args = listed[0]
        listed.append(listed.pop(0))
        run = trial.run(kind, args, at={stage: holds})
        run.ends(trial.limit_of(kind) + trial.limits.answer_s)
        return run if calls else None

    yield from _judged(trial, begin, calls, words)


def _on_the_way(trial: Trial, listed: Motions, looks: int, threads: int) -> Iterator[str]:
    """Hold once the robot was seen moving so many times."""
    calls: list[Call] = []
    words = f"after it was seen moving {looks} times" if threads == 1 else f"from {threads} threads at once"

    def begin() -> Run | None:
        run = underway(trial, listed, looks)
        if run is not None:
            calls[:] = [trial.call(trial.opened_session().hold, "hold") for _ in range(threads)]
        return run

    yield from _judged(trial, begin, calls, words)


def _judged(trial: Trial, begin: Callable[[], Run | None], calls: list[Call], words: str) -> Iterator[str]:
    """Judge a command that was held; one that had just reached its end is tried again."""
    for _ in range(TRIES):
        trial.settle()
        run = begin()
        if run is None:
            continue
        wrong = [sentence for call in calls for sentence in _held(trial, call, words)]
        yield from wrong
        if not run.ends(trial.limits.answer_s):
            yield f"execute goes on after hold() {words}; end it with MotionHeld."
            return
        if wrong or isinstance(run.error, MotionHeld):
            yield from _rests(trial, words) if not wrong else ()
            return
        if run.error is not None:
            yield f"execute ended with {error_text(run.error)} after hold() {words}; raise MotionHeld."
            return
    if run is None:
        yield Note(f"No motion lasts so long that it can be held {words}.")
    else:
        yield f"execute returned as if nothing had happened after hold() {words}; raise MotionHeld."


def _held(trial: Trial, call: Call, words: str) -> Iterator[str]:
    if not call.ends(trial.limits.answer_s) or call.late:
        yield f"hold() {words} did not return; it must not wait for the command, nor for a lock that execute holds."
    elif call.error is not None:
        yield f"hold() {words} raised {error_text(call.error)}."
    elif not isinstance(call.value, RobotState):
        yield f"hold() {words} returned {type(call.value).__name__} instead of a RobotState."
    elif call.value.moving:
        yield f"hold() {words} returned a state that moves; return when the robot rests."


def _rests(trial: Trial, words: str) -> Iterator[str]:
    """Look some more: a robot that was held does not go on."""
    session, counted = trial.opened_session(), trial.motion_count()
    first = session.state()
    for _ in range(REST_LOOKS):
        trial.clock.sleep(REST_S)
        state = session.state()
        if state.moving or apart(first.joints, state.joints) > STILL:
            yield f"The robot moves on after hold() {words} has returned; bring it to rest before."
            return
    if trial.counted_since(counted):
        yield f"The simulator counted another motion after hold() {words} had returned; end the command for good."


def held_kinds(trial: Trial) -> Iterator[str]:
    """A motion with held controls calls `permit` again and again, and ends with the error that it raises."""
    trial.ready_session()
    kinds = [c for c in trial.motions() if c.held and motions_of(trial, c)]
    if not kinds:
        raise NotApplicable("no kind of command is held")
    for command in kinds:
        trial.settle()
        run = underway(trial, motions_of(trial, command))
        if run is None:
            yield Note(f"The held motion {command.kind!r} was not seen moving.")
            continue
        what, asked = command_text(run.kind, run.args), run.permits
        trial.poll(partial(_goes_on, run, asked), trial.limits.answer_s)
        if not run.permits_on_way:
            yield f"{what} does not call permit() while it moves; call it again and again."
        run.refuse = denial()
        if not run.ends(trial.limits.answer_s):
            yield f"{what} goes on after its controls were released."
        elif run.error is not run.refuse and run.refused.is_set():
            yield (
                f"{what} ended with {error_text(run.error)} after permit() raised on its way; let it through as it is."
            )
        if not trial.poll(lambda: not trial.opened_session().state().moving, trial.limits.answer_s):
            yield f"The robot does not come to rest after the controls of {what} were released."


def _goes_on(run: Run, asked: int) -> bool:
    return run.permits > asked or run.over.is_set()


def replaced(trial: Trial) -> Iterator[str]:
    """A replaceable motion calls `permit` on its way, and leaves the robot to the next target."""
    trial.ready_session()
    kinds = [c for c in trial.motions() if c.replaceable and len(motions_of(trial, c)) > 1]
    if not kinds:
        raise NotApplicable("no kind of command is replaceable and has two places to go to")
    for command in kinds:
        trial.settle()
        listed = motions_of(trial, command)
        run = underway(trial, listed)
        if run is None:
            yield Note(f"No motion of the kind {command.kind!r} lasts so long that it can be replaced.")
            continue
        what, run.refuse = command_text(run.kind, run.args), MotionReplaced("A newer target takes its place.")
        if not run.ends(trial.limit_of(command.kind)):
            yield f"{what} goes on after permit() raised MotionReplaced."
            continue
        if not run.refused.is_set():
            yield f"{what} did not call permit() on its way, so nothing can replace it; call it while the robot moves."
        elif run.error is not run.refuse:
            yield f"{what} ended with {error_text(run.error)} after permit() raised MotionReplaced; let it through."
        after = trial.run(*listed[0])
        if not trial.poll(after.has_begun, trial.limits.answer_s):
            yield f"No target can follow {what} after it was replaced."
        elif after.over.is_set() and after.error is not None:
            yield f"The target that replaced {what} ended with {error_text(after.error)}."
