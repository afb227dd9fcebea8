"""Checks of a line that is lost, disturbed or closed, and of the way back."""

from collections.abc import Iterator

from robots.kit.conformance.commands import STILL
from robots.kit.conformance.motions import longest, underway
from robots.kit.conformance.report import NotApplicable
from robots.kit.conformance.runs import ACKNOWLEDGED, Call, Run, command_text, denial, error_text
from robots.kit.conformance.states import wrong_in
from robots.kit.conformance.trial import Broken, Faults, Trial, apart
from robots.kit.contract.errors import HardwareFault, RobotError

NOISE = (("corrupt", 0.02), ("drop", 0.02), ("double", 0.05), ("slow", 0.3))
SILENT = ("awol", "mute")
RESTARTS = ("power_cycle", "restart")
COMMANDS = 3  # carried out over a noisy line


def close_under_motion(trial: Trial) -> Iterator[str]:
    """`close` under a motion returns, ends the command, and the robot can be connected again and rests."""
    session, shut = trial.ready_session(), list[Call]()

    def close() -> None:
        shut.append(trial.call(session.close, "close"))
        shut[0].ends(trial.limits.answer_s)

    kind, args = longest(trial)[0]
    run = trial.run(kind, args, at={ACKNOWLEDGED: close})
    if not trial.poll(lambda: shut or run.over.is_set(), trial.limits.answer_s):
        yield f"{command_text(kind, args)} was not acknowledged."
        return
    if not run.ends(trial.limit_of(kind)):
        yield "execute did not end after close(); let it raise LineGone."
    elif run.error is not None and not isinstance(run.error, RobotError):
        yield f"execute ended with {error_text(run.error)} after close(); raise LineGone."
    if shut and shut[0].late:
        yield "close() under a motion did not return; it must not wait for the command."
    elif shut and shut[0].error is not None:
        yield f"close() under a motion raised {error_text(shut[0].error)}; it never raises."
    yield from _comes_back(trial, "after close() under a motion")


def _comes_back(trial: Trial, when: str) -> Iterator[str]:
    """Connect again, hold what still moves, and look whether commands are carried out."""
    session = trial.opened_session()
    try:
        if trial.connected(session).moving and trial.state_from(session.hold, "hold").moving:
            yield f"The robot moves on {when}, although it was connected and held again."
        trial.settle()
    except Broken as error:
        yield f"{str(error).rstrip('.')}, {when}."


def recovery(trial: Trial) -> Iterator[str]:
    """`recover` calls its permit, lets its error through, and returns the state of a ready robot."""
    session = trial.ready_session()
    asked, refuse, before = 0, denial(), session.state()

    def count() -> None:
        nonlocal asked
        asked += 1

    def deny() -> None:
        count()
        raise refuse

    call = trial.call(lambda: session.recover(deny), "recover")
    if not call.ends(trial.limits.answer_s):
        yield "recover() does not end although permit() raised."
    elif not asked:
        yield "recover() never called permit(); call it right before each actuation."
    elif call.error is not refuse:
        yield f"permit() raised in recover(), which answered {error_text(call.error)}; let it through as it is."
    after = session.state()
    if after.moving or apart(before.joints, after.joints) > STILL:
        yield "The robot moved in recover() although permit() had raised."
    state = trial.state_from(lambda: session.recover(count), "recover")
    if not state.ready or state.fault:
        yield f"The robot is not ready after recover(): {state.fault or 'it does not say why'}."
    yield from (f"The state that recover() returns {wrong}" for wrong in wrong_in(trial, state))


def board_of(trial: Trial) -> Faults:
    """Return the fault board. Raises NotApplicable where there is none."""
    if trial.faults is None:
        raise NotApplicable("there is no fault board, as simulators of Farhand have one")
    return trial.faults


def lost_line(trial: Trial) -> Iterator[str]:
    """A robot that falls silent in a motion is a fault with a sentence, and it can be connected again."""
    board = board_of(trial)
    for verb in SILENT:
        run, session = _begun(trial), trial.opened_session()
        board.set(verb)
        trial.poll(run.over.is_set, trial.limits.watch_s)
        asked = trial.call(session.state, "state")
        if not asked.ends(trial.limits.answer_s):
            yield f"state() does not return under the fault {verb!r}; raise LineSilent or LineGone."
        elif asked.error is None and (not run.over.is_set() or run.error is None):
            trial.settle()
            continue  # nothing was noticed
        elif asked.error is not None and not is_fault(asked.error):
            yield (
                f"state() raised {error_text(asked.error)} under the fault {verb!r}; "
                "raise a HardwareFault with a sentence."
            )
        yield from _ended(trial, run, f"under the fault {verb!r}")
        yield from _mended(trial, board, f"after the fault {verb!r}")
        return
    raise NotApplicable(f"no fault of the simulator makes it silent ({', '.join(SILENT)})")


def lost_power(trial: Trial) -> Iterator[str]:
    """A controller that restarts in a motion is a fault with a sentence, and it can be connected again."""
    board = board_of(trial)
    boots = board.boots()
    if boots is None:
        raise NotApplicable("the simulator does not tell when its controller is started again")
    for verb in RESTARTS:
        run = _begun(trial)
        board.set(verb, 1.0, 1)
        if trial.poll(lambda: board.boots() != boots, trial.limits.watch_s):
            yield from _ended(trial, run, f"under the fault {verb!r}")
            yield from _mended(trial, board, f"after the fault {verb!r}")
            return
        board.clear()
        trial.settle()
    raise NotApplicable("no fault of the simulator starts its controller again")


def _begun(trial: Trial) -> Run:
    trial.ready_session()
    run = underway(trial, longest(trial))
    if run is None:
        raise NotApplicable("no motion lasts so long")
    return run


def is_fault(error: BaseException | None) -> bool:
    """Tell whether an error is one of the machine's, with a sentence."""
    return isinstance(error, HardwareFault) and bool(str(error).strip())


def _ended(trial: Trial, run: Run, when: str) -> Iterator[str]:
    if not run.ends(trial.limit_of(run.kind)):
        yield f"execute did not end within its limit {when}."
    elif run.error is not None and not isinstance(run.error, RobotError):
        yield f"execute ended with {error_text(run.error)} {when}; raise a HardwareFault with a sentence."


def _mended(trial: Trial, board: Faults, when: str) -> Iterator[str]:
    board.clear()
    try:
        trial.settle()
    except Broken as error:
        yield f"{str(error).rstrip('.')}, {when}."


def noise(trial: Trial) -> Iterator[str]:
    """Bytes that are corrupted, lost, doubled or late cost time, never a wrong state or an error without a sentence."""
    board, taken = board_of(trial), False
    trial.ready_session()
    listed = longest(trial)
    for verb, value in NOISE:
        trial.settle()
        if not board.set(verb, value):
            continue
        taken = True
        for kind, args in listed[:COMMANDS]:
            run = trial.run(kind, args)
            for state in trial.looks(run, trial.limits.watch_s / COMMANDS):
                yield from (f"Under the fault {verb!r} state() {wrong}" for wrong in wrong_in(trial, state))
            if not run.over.is_set():
                trial.call(trial.opened_session().hold, "hold").ends(trial.limits.answer_s)
            if not run.ends(trial.limit_of(kind)):
                yield f"execute did not end within its limit under the fault {verb!r}."
            elif run.error is not None and not isinstance(run.error, RobotError):
                yield f"execute ended with {error_text(run.error)} under the fault {verb!r}; raise a HardwareFault."
            if isinstance(run.error, HardwareFault):
                break
        board.clear()
    if not taken:
        raise NotApplicable("the simulator has none of the faults corrupt, drop, double and slow")
