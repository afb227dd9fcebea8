"""The verbs of queues, by subject. One verb is one function.

Every change of a queue happens under a lock of its row (PostgreSQL) or of the database (SQLite, immediate
transactions), so two ticks or two people cannot interleave.
"""

from queueing.jobs.asking import ask
from queueing.jobs.cancelling import cancel
from queueing.jobs.foreseeing import foreseen
from queueing.offers import accept
from queueing.presence import disconnected, dismiss, present, seen
from queueing.rows import queue_of
from queueing.tick import tick
from queueing.tickets import join, leave, open_ticket, remove
from queueing.turns import acted, end_turn, note_act, open_turn, turn_of

__all__ = (  # noqa: RUF022 - in the order of the rooms
    # the queue of a robot
    "queue_of",
    # tickets
    "join", "leave", "open_ticket", "remove",
    # offers
    "accept",
    # turns
    "acted", "end_turn", "note_act", "open_turn", "turn_of",
    # presence
    "disconnected", "dismiss", "present", "seen",
    # jobs, and how long they will wait
    "ask", "cancel", "foreseen",
    # time
    "tick",
)  # fmt: skip
