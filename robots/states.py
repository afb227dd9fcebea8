"""The states of commands, robots and grants, with their allowed transitions and labels."""

from django.db import models


class CommandState(models.TextChoices):
    """A command's life; the last five and `completed` are final."""

    QUEUED = "queued", "Queued"
    ACCEPTED = "accepted", "Accepted"
    SENT = "sent", "Sent"
    ACKNOWLEDGED = "acknowledged", "Moving"
    COMPLETED = "completed", "Settled"
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


class Cycle(models.TextChoices):
    """Where a robot is in its turn cycle."""

    OFFLINE = "offline", "Offline"
    READY = "ready", "Ready"
    OFFERED = "offered", "Offered to the next person"
    OPERATING = "operating", "In use"
    HANDOVER = "handover", "Being put back in order"
    FAULT = "fault", "Faulty"
    LOCKED_OUT = "locked_out", "Locked out by staff"


class GrantKind(models.TextChoices):
    """On what ground a robot may move."""

    TURN = "turn", "Turn"
    GOAL = "goal", "Shared goal"
    STAFF = "staff", "Staff"
    HANDOVER = "handover", "Handover"
    UPKEEP = "upkeep", "One command of staff"
    ATTRACT = "attract", "Attract loop"
