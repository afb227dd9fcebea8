"""Checks of `execute`: values that it takes or refuses, its calls of `permit`, and the stages that it tells."""

from collections.abc import Iterator

from robots.kit.conformance.report import NotApplicable, Note
from robots.kit.conformance.runs import ACKNOWLEDGED, SENT, Run, command_text, denial, error_text
from robots.kit.conformance.trial import ENDLESS, Trial, apart
from robots.kit.conformance.values import bad, base, ends, good, is_refusal, refusal
from robots.kit.contract.errors import BadRequest, GaveUp, MotionHeld, OutOfWorkspace, RobotError
from robots.kit.contract.session import JSON, Progress
from robots.kit.contract.spec import CommandKind
from robots.kit.contract.values import not_shown

STILL = 0.01  # rad, m: readings this close are of a robot that did not move


def values(trial: Trial) -> Iterator[str]:
    """Every number is tried at its ends and past them; a refusal comes before `permit` is called."""
    session = trial.ready_session()
    before, counted = session.state(), trial.motion_count()
    for command in trial.spec.commands:
        given = base(trial, command)
        for args in ends(command, given):
            yield from _at_an_end(trial, command.kind, args)
        for args in bad(command, given):
            run = _probed(trial, command.kind, args)
            what = command_text(command.kind, args)
            if run.permits or run.error is None:
                yield f"execute takes {what}; refuse it with BadRequest or OutOfWorkspace before permit() is called."
            elif not isinstance(run.error, BadRequest | OutOfWorkspace) or not is_refusal(run.error):
                yield f"execute answers {what} by {error_text(run.error)}; raise BadRequest with a sentence."
            refused = refusal(trial, command.kind, args, session.latest())
            if not is_refusal(refused):
                yield f"The check of the spec answers {what} by {error_text(refused)}; it has to raise BadRequest."
    run = _probed(trial, "no_such_command", {})
    if not isinstance(run.error, BadRequest):
        yield f"execute answers a kind that the spec does not declare by {error_text(run.error)}; raise BadRequest."
    after = session.state()
    if after.moving or apart(before.joints, after.joints) > STILL or trial.counted_since(counted):
        yield "The robot moved although no permit was given and most values were refused."


def _at_an_end(trial: Trial, kind: str, args: JSON) -> Iterator[str]:
    run = _probed(trial, kind, args)
    if run.error is run.refuse:
        return
    if run.error is None:
        if run.permits:
            yield f"execute({kind!r}) goes on although permit() raised; let what it raises through."
    elif not is_refusal(run.error):
        yield (
            f"execute answers {command_text(kind, args)} by {error_text(run.error)}; "
            "take it, or refuse it with a sentence."
        )


def _probed(trial: Trial, kind: str, args: JSON) -> Run:
    """Carry out a command whose permit raises, so that nothing moves even if the driver takes the values."""
    run = trial.run(kind, args, denial())
    if not run.ends(trial.limits.answer_s):
        run.error = TimeoutError("it did not end although permit() raised, or was not called")
    return run


def permit(trial: Trial) -> Iterator[str]:
    """Without a permit nothing moves, and the error of the permit comes out as it is."""
    session, tried = trial.ready_session(), 0
    for command in trial.spec.commands:
        for args in good(trial, command)[:2]:
            before, counted = session.state(), trial.motion_count()
            run, what = _probed(trial, command.kind, args), command_text(command.kind, args)
            if isinstance(run.error, RobotError) and not run.permits:
                continue  # the robot has a reason of its own
            tried += 1
            if not run.permits:
                yield f"execute never called permit() for {what}; call it right before each actuation."
            elif run.error is not run.refuse:
                yield (
                    f"permit() raised for {what}, and execute answered {error_text(run.error)}; "
                    "let it through as it is."
                )
            if run.stages:
                yield f"execute told {run.stages[0]!r} of {what} although permit() had raised."
            after = session.state()
            if after.moving or apart(before.joints, after.joints) > STILL:
                yield f"The robot moved by {what} although permit() had raised; call permit() before the actuation."
            elif trial.counted_since(counted):
                yield f"The simulator counted a motion by {what} although permit() had raised."
    if not tried:
        raise NotApplicable("no command could be carried out; give examples of values in robot.toml")


def carried_out(trial: Trial) -> Iterator[str]:
    """Every kind is carried out once or twice, watched, and ended in the way of its kind."""
    left = []
    for command in trial.spec.commands:
        trial.ready_session()
        tried = good(trial, command)[:2]
        if not tried:
            left.append(command.kind)
        for args in tried:
            trial.settle()
            yield from _watched(trial, command, args)
    if len(left) == len(trial.spec.commands):
        raise NotApplicable("no command could be carried out; give examples of values in robot.toml")
    if left:
        yield Note(f"Not carried out, because no good values are known: {', '.join(left)}.")


def _watched(trial: Trial, command: CommandKind, args: JSON) -> Iterator[str]:
    run, what = trial.run(command.kind, args), command_text(command.kind, args)
    trial.poll(run.has_begun, trial.limits.answer_s)
    since, moving = trial.clock.monotonic(), 0.0
    for state in trial.looks(run, trial.limits.watch_s):
        if state.moving:
            moving = trial.clock.monotonic() - since
    endless = not run.over.is_set()
    trial.moved[command.kind] = max(trial.moved.get(command.kind, 0.0), moving + ENDLESS * (endless and moving > 0))
    if endless and command.held:
        yield from _released(trial, run, what)
    elif endless:
        trial.state_from(trial.opened_session().hold, "hold")
    if not run.ends(trial.limit_of(command.kind)):
        yield f"{what} did not end within its limit of {command.limit_s:g} s; end it, or give it a longer limit_s."
        return
    yield from _judged(run, command, what, held=endless)
    if run.error is None or isinstance(run.error, MotionHeld):
        state = trial.state_from(trial.opened_session().state, "state")
        if state.moving:
            yield f"The robot moves after {what} has ended; return when it is at rest."
        elif run.error is None and (wrong := not_shown(command, args, trial.spec.named(state))) is not None:
            yield f"After {what}, {wrong}"


def _judged(run: Run, command: CommandKind, what: str, held: bool) -> Iterator[str]:
    told = run.named_stages()
    if run.error is None and run.outcome is None:
        yield f"execute returned {type(run.value).__name__} for {what}; return an Outcome."
    if run.error is not None and run.error is not run.refuse and not is_refusal(run.error):
        yield (
            f"{what} ended with {error_text(run.error)}; "
            "raise an error of robots/kit/contract/errors.py with a sentence."
        )
    if isinstance(run.error, BadRequest | OutOfWorkspace) and not told:
        return
    if isinstance(run.error, RobotError) and not held and not isinstance(run.error, MotionHeld | GaveUp):
        yield f"{what} ended with {error_text(run.error)}, although nothing was in its way."
    yield from stages(run, command, what)


def stages(run: Run, command: CommandKind, what: str) -> Iterator[str]:
    """Tell what is wrong with the stages of a command that was carried out."""
    told = run.named_stages()
    if run.error is not None and told[-1:] == [SENT]:
        told = told[:-1]  # it ended there
    if any(stage not in (SENT, ACKNOWLEDGED) for stage in told):
        yield f'{what} told the stages {told[:4]}; there are "sent", "acknowledged" and a Progress.'
    elif told != [SENT, ACKNOWLEDGED] * (len(told) // 2):
        yield f'{what} told the stages {told[:4]}; tell "sent" when it was sent, then "acknowledged", each once.'
    if command.moves and not told and (run.error is None or isinstance(run.error, MotionHeld)):
        yield f'{what} told no stage; call on_stage("sent") and on_stage("acknowledged").'
    if told and not run.permits_at_sent:
        yield f"{what} was sent before permit() was called; call it right before each actuation."
    if run.stages and isinstance(run.stages[0], Progress):
        yield f'{what} told a Progress before "acknowledged".'


def _released(trial: Trial, run: Run, what: str) -> Iterator[str]:
    """Release the controls of a held motion."""
    run.refuse = denial()
    if not run.ends(trial.limits.answer_s):
        yield f"{what} went on after its controls were released; call permit() again and again while it moves."
        trial.state_from(trial.opened_session().hold, "hold")
    elif run.error is not run.refuse:
        yield (
            f"permit() raised on the way of {what}, and it ended with {error_text(run.error)}; let it through as it is."
        )
    if not trial.poll(lambda: not trial.opened_session().state().moving, trial.limits.answer_s):
        yield f"The robot does not come to rest after the controls of {what} were released."
