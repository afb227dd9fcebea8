"""The states of commands, robots and grants, with their allowed transitions and labels."""

from django.db import models


class CommandState(models.TextChoices):
    """The states of a command; `completed` and the last five are final."""

    QUEUED = "queued", "Queued"
    ACCEPTED = "accepted", "Accepted"
    SENT = "sent", "Sent"
    ACKNOWLEDGED = "acknowledged", "Moving"
    COMPLETED = "completed", "Done"
    REJECTED = "rejected", "Rejected"
    FAILED = "failed", "Failed"
    EXPIRED = "expired", "Expired"
    CANCELLED = "cancelled", "Cancelled"
    UNKNOWN = "unknown", "Unknown"


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

    MOTION = "motion", "Motion"
    CONFIG = "config", "Beside a motion"


class Cycle(models.TextChoices):
    """The states of a robot in its turn cycle."""

    OFFLINE = "offline", "Offline"
    READY = "ready", "Ready"
    OFFERED = "offered", "Offered to the next person"
    OPERATING = "operating", "In use"
    HANDOVER = "handover", "Being put back in order"
    FAULT = "fault", "Faulty"
    LOCKED_OUT = "locked_out", "Locked out by staff"


class GrantKind(models.TextChoices):
    """The purpose of a grant."""

    TURN = "turn", "Turn"
    JOB = "job", "Job"
    STAFF = "staff", "Staff"
    HANDOVER = "handover", "Handover"
    SETTINGS = "settings", "Settings set back"
    IDLE = "idle", "Idle behaviour"
    UPKEEP = "upkeep", "Upkeep"
    REST = "rest", "Comes to rest"


# Properties of grants by their kind:
G = GrantKind
ASKED_FOR = frozenset({G.TURN, G.JOB})  # a visitor asked for it; it is recorded
ONE_COMMAND = frozenset({G.JOB, G.IDLE, G.UPKEEP})  # it is opened for one command, and ends with it
IN_ORDER = frozenset({G.HANDOVER, G.SETTINGS})  # the owner puts the robot in order, or a part of it
GIVES_WAY_TO_QUEUE = frozenset({G.JOB, G.IDLE})  # preempted by the next request in the queue, or a need of the robot
GIVES_WAY_TO_STAFF = frozenset({G.IDLE, G.REST})  # preempted by a command of staff


class GrantEnd(models.TextChoices):
    """Why a grant ended; `end_reason` says it to people."""

    FINISHED = "finished", "What it was opened for is done"
    FAILED = "failed", "What it was opened for failed"
    TIME_UP = "time_up", "Time is up"
    HOLDER = "holder", "Ended by its holder"
    STAFF = "staff", "Ended by staff"
    ABSENT = "absent", "Connection lost"
    IDLE = "idle", "Nothing was done while others waited"
    SILENT = "silent", "The console without scripts sent nothing"
    SIGNED_OUT = "signed_out", "Signed out"
    UNFIT = "unfit", "Account or clearance withdrawn"
    STOPPED = "stopped", "The robot was stopped"
    LOCKED_OUT = "locked_out", "Locked out by staff"
    SWITCHED_OFF = "switched_off", "Switched off by staff"
    OWNER_LOST = "owner_lost", "The robot's worker was interrupted"
    PREEMPTED = "preempted", "Somebody else came first"
    RESTORED = "restored", "Restored from a backup"
