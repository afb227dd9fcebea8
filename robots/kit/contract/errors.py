"""Errors between a person and a robot; each has one sentence for the person.

`BadRequest` is the person's, `OutOfWorkspace` the robot's limits, `HardwareFault` the machine's, `NotPermitted` the
rules'.
"""

import errno

from robots.kit.addresses import redacted

ENDED, NO_WAY, FULL = "the other side ended it", "no way leads there any more", "the disk is full"
PLAIN = {
    errno.ECONNRESET: ENDED, errno.ECONNABORTED: ENDED, errno.EPIPE: ENDED, errno.EHOSTUNREACH: NO_WAY,
    errno.ENETUNREACH: NO_WAY, errno.ENETDOWN: NO_WAY, errno.ETIMEDOUT: "nothing answered for too long",
    errno.ENOSPC: FULL, errno.EDQUOT: FULL,
}  # fmt: skip


class RobotError(Exception):
    """Base class; `str()` is a sentence for people, without the secrets of addresses that libraries put into errors."""

    code = "error"

    def __str__(self) -> str:
        """Return the sentence."""
        return redacted(super().__str__())


class BadRequest(RobotError):
    """The command makes no sense: unknown kind, missing or malformed value."""

    code = "bad_request"


class NotCalibrated(RobotError):
    """There is no calibration for the command, or its measurement failed."""

    code = "calibration"


class OutOfWorkspace(RobotError):
    """The target lies where the robot must not or cannot go."""

    code = "out_of_workspace"


class NotPermitted(RobotError):
    """The rules forbid the motion now."""

    code = "not_permitted"


class Stopped(NotPermitted):
    """A stop is latched."""

    code = "stopped"


class StaleEpoch(NotPermitted):
    """This process no longer owns the robot."""

    code = "stale_epoch"


class GrantOver(NotPermitted):
    """The grant under which the command was given has ended."""

    code = "grant_over"


class TooLate(NotPermitted):
    """The command did not start before its deadline."""

    code = "too_late"


class ControlsReleased(NotPermitted):
    """The controls of a held motion were released, or their keep-alives ended."""

    code = "controls_released"


class MotionHeld(RobotError):
    """A hold cut the motion short."""

    code = "held"


class MotionReplaced(MotionHeld):
    """A newer target replaced this one while the robot moved."""

    code = "replaced"


Held, Replaced = MotionHeld, MotionReplaced  # their names in 0.1, until 1.0


class GaveUp(RobotError):
    """The robot is in order but did not manage what it was asked; it is not tried again by itself."""

    code = "gave_up"


class HardwareFault(RobotError):
    """The robot did not do what was asked, or does not answer."""

    code = "hardware_fault"


class LineSilent(HardwareFault):
    """All resends were used up without an acknowledgement."""

    code = "line_silent"


class LineBusy(HardwareFault):
    """Another process holds the port."""

    code = "line_busy"


class LineGone(HardwareFault):
    """The port vanished: cable pulled, device gone."""

    code = "line_gone"


class ControllerRefused(HardwareFault):
    """The controller answered with an error."""

    code = "controller_refused"


class ControllerRestarted(HardwareFault):
    """The controller lost power or was reset by something else."""

    code = "controller_restarted"


class CameraFault(HardwareFault):
    """The camera does not deliver a usable picture."""

    code = "camera_fault"


def why(error: BaseException) -> str:
    """Return in a few words what the system or a library said, without the path of a file: people read this."""
    if isinstance(error, OSError) and error.errno in PLAIN:
        return PLAIN[error.errno]
    try:
        told = str(getattr(error, "strerror", None) or error).strip().splitlines()
    except Exception:  # noqa: BLE001 - of the error's own text
        told = []
    return redacted(told[0])[:160].rstrip(". ") if told else type(error).__name__
