"""The states of commands, robots and grants, with their allowed transitions and labels."""

from django.db import models
from django.utils.translation import gettext_lazy


class CommandState(models.TextChoices):
    """The states of a command; `completed` and the last five are final."""

    QUEUED = "queued", gettext_lazy("Queued")
    ACCEPTED = "accepted", gettext_lazy("Accepted")
    SENT = "sent", gettext_lazy("Sent")
    ACKNOWLEDGED = "acknowledged", gettext_lazy("Moving")
    COMPLETED = "completed", gettext_lazy("Done")
    REJECTED = "rejected", gettext_lazy("Rejected")
    FAILED = "failed", gettext_lazy("Failed")
    EXPIRED = "expired", gettext_lazy("Expired")
    CANCELLED = "cancelled", gettext_lazy("Cancelled")
    UNKNOWN = "unknown", gettext_lazy("Unknown")


C = CommandState
COMMAND_FINAL = frozenset({C.COMPLETED, C.REJECTED, C.FAILED, C.EXPIRED, C.CANCELLED, C.UNKNOWN})
COMMAND_RUNNING = frozenset({C.ACCEPTED, C.SENT, C.ACKNOWLEDGED})
COMMAND_NEXT: dict[str, frozenset[str]] = {
    C.QUEUED: frozenset({C.ACCEPTED, C.REJECTED, C.EXPIRED, C.CANCELLED}),
    C.ACCEPTED: frozenset({C.SENT, C.COMPLETED, C.REJECTED, C.FAILED, C.EXPIRED, C.CANCELLED, C.UNKNOWN}),
    C.SENT: frozenset({C.ACKNOWLEDGED, C.COMPLETED, C.REJECTED, C.FAILED, C.CANCELLED, C.UNKNOWN}),
    C.ACKNOWLEDGED: frozenset({C.COMPLETED, C.FAILED, C.CANCELLED, C.UNKNOWN}),
    **{final: frozenset() for final in COMMAND_FINAL},
}


class Lane(models.TextChoices):
    """The lane in which a command runs: `motion`, one at a time, or `config`, in parallel to a motion."""

    MOTION = "motion", gettext_lazy("Motion")
    CONFIG = "config", gettext_lazy("Beside a motion")


class Cycle(models.TextChoices):
    """The states of a robot in its turn cycle."""

    OFFLINE = "offline", gettext_lazy("Offline")
    READY = "ready", gettext_lazy("Ready")
    OFFERED = "offered", gettext_lazy("Offered to the next person")
    OPERATING = "operating", gettext_lazy("In use")
    HANDOVER = "handover", gettext_lazy("Being put back in order")
    FAULT = "fault", gettext_lazy("Faulty")
    LOCKED_OUT = "locked_out", gettext_lazy("Locked out by staff")


class GrantKind(models.TextChoices):
    """The purpose of a grant."""

    TURN = "turn", gettext_lazy("Turn")
    JOB = "job", gettext_lazy("Job")
    STAFF = "staff", gettext_lazy("Staff")
    HANDOVER = "handover", gettext_lazy("Handover")
    SETTINGS = "settings", gettext_lazy("Settings set back")
    IDLE = "idle", gettext_lazy("Idle behaviour")
    UPKEEP = "upkeep", gettext_lazy("Upkeep")
    REST = "rest", gettext_lazy("Comes to rest")


# Properties of grants by their kind:
G = GrantKind
ASKED_FOR = frozenset({G.TURN, G.JOB})  # a visitor asked for it; it is recorded
ONE_COMMAND = frozenset({G.JOB, G.IDLE, G.UPKEEP})  # it is opened for one command, and ends with it
IN_ORDER = frozenset({G.HANDOVER, G.SETTINGS})  # the owner puts the robot in order, or a part of it
GIVES_WAY_TO_QUEUE = frozenset({G.JOB, G.IDLE})  # preempted by the next request in the queue, or a need of the robot
GIVES_WAY_TO_STAFF = frozenset({G.IDLE, G.REST})  # preempted by a command of staff


class GrantEnd(models.TextChoices):
    """Why a grant ended; `end_reason` says it to people."""

    FINISHED = "finished", gettext_lazy("What it was opened for is done")
    FAILED = "failed", gettext_lazy("What it was opened for failed")
    TIME_UP = "time_up", gettext_lazy("Time is up")
    HOLDER = "holder", gettext_lazy("Ended by its holder")
    STAFF = "staff", gettext_lazy("Ended by staff")
    ABSENT = "absent", gettext_lazy("Connection lost")
    IDLE = "idle", gettext_lazy("Nothing was done while others waited")
    SILENT = "silent", gettext_lazy("The console without scripts sent nothing")
    SIGNED_OUT = "signed_out", gettext_lazy("Signed out")
    UNFIT = "unfit", gettext_lazy("Account or clearance withdrawn")
    STOPPED = "stopped", gettext_lazy("The robot was stopped")
    LOCKED_OUT = "locked_out", gettext_lazy("Locked out by staff")
    SWITCHED_OFF = "switched_off", gettext_lazy("Switched off by staff")
    OWNER_LOST = "owner_lost", gettext_lazy("The robot's worker was interrupted")
    PREEMPTED = "preempted", gettext_lazy("Somebody else came first")
    RESTORED = "restored", gettext_lazy("Restored from a backup")
