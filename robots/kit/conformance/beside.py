"""Checks of settings, byte streams and pictures beside motions; and of the end."""

import threading
import urllib.request
from collections.abc import Iterator
from functools import partial
from io import BytesIO

from PIL import Image

from robots.kit.conformance.motions import longest
from robots.kit.conformance.report import NotApplicable
from robots.kit.conformance.runs import ACKNOWLEDGED, Run, command_text, error_text
from robots.kit.conformance.trial import Trial, children
from robots.kit.conformance.values import good
from robots.kit.contract.errors import RobotError
from robots.kit.contract.session import JSON
from robots.kit.contract.spec import CommandKind
from robots.kit.contract.values import number_for
from robots.kit.description import views

PICTURE_S = 20.0
LARGEST = 20_000_000  # bytes of a picture
SAME = 1e-3  # of a channel that shows a value that was set


def lanes(trial: Trial) -> Iterator[str]:
    """A setting is changed beside a motion: it neither waits for the motion nor ends it."""
    kinds = [c for c in trial.spec.commands if c.lane == "config"]
    if not kinds:
        raise NotApplicable("no kind has the lane config")
    trial.ready_session()
    listed = longest(trial)
    for command in kinds:
        values: list[JSON] = [*good(trial, command)[:1], *([dict(command.default)] if command.default else [])]
        for args in values:
            trial.settle()
            try:
                yield from _beside(trial, listed[0], command.kind, args)
            except _Refused:  # that kind may use what is set
                listed = longest(trial, but=listed[0][0])
                trial.settle()
                yield from _told(_beside(trial, listed[0], command.kind, args))
            listed.append(listed.pop(0))
            yield from _shown(trial, command, args)


class _Refused(Exception):
    """The robot refused a setting beside a motion."""


def _told(words: Iterator[str]) -> Iterator[str]:
    try:
        yield from words
    except _Refused as error:
        yield str(error)


def _beside(trial: Trial, motion: tuple[str, JSON], kind: str, args: JSON) -> Iterator[str]:
    """Change a setting while the motion's `acknowledged` is told, so that the motion cannot end before.

    Raises _Refused.
    """
    session, setting, what = trial.opened_session(), list[Run](), command_text(kind, args)

    def change() -> None:
        setting.append(Run(session, trial.clock, kind, args))
        setting[0].ends(trial.limits.answer_s)

    run = trial.run(*motion, at={ACKNOWLEDGED: change})
    if not trial.poll(lambda: run.acknowledged.is_set() or run.over.is_set(), 2 * trial.limits.answer_s) or not setting:
        return
    beside = setting[0]
    if beside.late:
        yield f"{what} waits for the motion that runs; it must need no lock that a motion or a hold needs."
    elif beside.error is not None and not isinstance(beside.error, RobotError):
        yield f"{what} beside a motion ended with {error_text(beside.error)}."
    elif beside.error is not None:
        raise _Refused(f"{what} was refused beside a motion: {error_text(beside.error)}.")
    if run.over.is_set() and run.error is not None:
        yield f"The motion ended with {error_text(run.error)} when {what} was carried out beside it."


def _shown(trial: Trial, command: CommandKind, args: JSON) -> Iterator[str]:
    session = trial.opened_session()
    for argument in command.arguments:
        channel = command.shown.get(argument.name)
        if channel is None or argument.name not in args:
            continue
        wanted = number_for(argument, args[argument.name])

        def reached(channel: str = channel, wanted: float = wanted) -> bool:
            value = trial.spec.named(session.state()).get(channel)
            return value is not None and abs(value - wanted) <= SAME

        if not trial.poll(reached, trial.limits.answer_s):
            yield (
                f"The channel {channel!r} does not show that {command.kind!r} was set to {wanted:g}; "
                "the robot is not offered until it does."
            )


def streams(trial: Trial) -> Iterator[str]:
    """Byte streams begin with a key packet, send another when asked, and stay within 1 MiB, in the whole suite."""
    yield from trial.recorder.wrong()
    heard = trial.recorder.counts
    if not heard:
        raise NotApplicable("the spec declares no byte stream")
    if not any(one.packets for one in heard.values()):
        raise NotApplicable(f"none of its streams told anything: {', '.join(heard)}")


def pictures(trial: Trial) -> Iterator[str]:
    """Each camera that comes over the robot's wire, or that its simulator serves, shows a picture of its size."""
    camera, listed = trial.description.get("camera"), views(dict(trial.description))
    addresses = trial.pictures()
    if camera is None or not (camera.get("by_driver") or addresses):
        raise NotApplicable("the robot has no camera over its own wire, and no address of a camera is known")
    session = trial.ready_session()
    for view in listed:
        if camera.get("by_driver"):
            call = trial.call(partial(session.picture, view, PICTURE_S), "picture")
            if not call.ends(PICTURE_S + trial.limits.answer_s):
                yield f"picture({view!r}, {PICTURE_S:g}) did not return; wait for so many seconds, not longer."
                continue
            if call.error is not None:
                yield f"picture({view!r}) raised {error_text(call.error)}; return None where there is no picture."
                continue
            data = call.value
        else:
            data = _fetched(addresses.get(view, ""))
        yield from (f"The camera {view!r} {wrong}" for wrong in _wrong_in(data, camera))


def _fetched(address: str) -> bytes | None:
    try:
        with urllib.request.urlopen(f"{address}/snapshot.jpg", timeout=PICTURE_S) as answer:  # noqa: S310 - as staff wrote
            data: bytes = answer.read(LARGEST)
            return data
    except (OSError, ValueError):
        return None


def _wrong_in(data: object, camera: JSON) -> Iterator[str]:
    if not isinstance(data, bytes):
        yield f"gave no picture within {PICTURE_S:g} s."
        return
    try:
        with Image.open(BytesIO(data), formats=("JPEG", "PNG")) as picture:
            picture.load()
            size = picture.size
    except Exception as error:  # noqa: BLE001 - of bytes of somebody else
        yield f"gave {len(data)} bytes that are no JPEG or PNG: {error_text(error)}."
        return
    wide, high = camera.get("width"), camera.get("height")
    if isinstance(wide, int) and isinstance(high, int) and not (size[0] <= wide and size[0] * high == size[1] * wide):
        yield f"gave a picture of {size[0]} x {size[1]} px; robot.toml says {wide} x {high}."


def end(trial: Trial) -> Iterator[str]:
    """`close` never raises, can be called again and before `connect`, and leaves no thread and no process."""
    session = trial.ready_session()
    for when in ("", " a second time"):
        call = trial.call(session.close, "close")
        if not call.ends(trial.limits.answer_s):
            yield f"close(){when} did not return."
        elif call.error is not None:
            yield f"close(){when} raised {error_text(call.error)}; it never raises."
    trial.session = None
    unopened = trial.opening()
    call = trial.call(unopened.close, "close")
    if not call.ends(trial.limits.answer_s) or call.error is not None:
        yield f"close() before connect() raised {error_text(call.error)}; it never raises."
    if not trial.poll(lambda: not _left(trial), trial.limits.answer_s):
        yield f"After close() these threads are left: {', '.join(_left(trial))}; end them in close()."
    if not trial.poll(lambda: children() <= trial.children, trial.limits.answer_s):
        yield f"After close() {len(children() - trial.children)} processes are left; end them in close()."


def _left(trial: Trial) -> list[str]:
    mine = ("conformance ",)
    return sorted(t.name for t in threading.enumerate() if t.ident not in trial.before and not t.name.startswith(mine))
