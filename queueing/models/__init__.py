"""Database rows of queues: tickets and turns, and jobs."""

from queueing.models.jobs import OPEN_JOB, Job, JobRun, JobState
from queueing.models.queues import (
    NOT_YET,
    OPEN_TICKET,
    SIDES,
    Account,
    Charge,
    LostCause,
    LostConnection,
    PlaceEnd,
    Queue,
    QueueRobot,
    Ticket,
    TicketState,
    Turn,
    TurnSession,
)

__all__ = (
    "NOT_YET",
    "OPEN_JOB",
    "OPEN_TICKET",
    "SIDES",
    "Account",
    "Charge",
    "Job",
    "JobRun",
    "JobState",
    "LostCause",
    "LostConnection",
    "PlaceEnd",
    "Queue",
    "QueueRobot",
    "Ticket",
    "TicketState",
    "Turn",
    "TurnSession",
)  # fmt: skip
