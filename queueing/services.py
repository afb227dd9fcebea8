"""The only door to queues for all other rooms: verbs, which change rows, and reads. One verb is one function.

Every change of a queue happens under a lock of its row (PostgreSQL) or of the database (SQLite, immediate
transactions), so two ticks or two people cannot interleave. Other rooms import only this module, the models and the
errors of queues; import-linter checks it.
"""

from queueing.endings import end_of_turn, is_news, last_turn
from queueing.estimates import place_and_wait, wait_if_joined, waiting, waiting_people
from queueing.jobs.asking import Asker, ask, job_of_form
from queueing.jobs.forecasts import Forecast, forecast, in_order
from queueing.jobs.kinds import job_kinds, kinds_for, label_of, offers_turns
from queueing.jobs.own import cancel, mark_seen, may_answer, may_cancel, note_answered, own_jobs, unseen_jobs
from queueing.jobs.running import FAULTS
from queueing.jobs.suspending import RESUMED, resume, waits_for_staff
from queueing.leaving import Place, end_session, last_report_elsewhere, mark_disconnected, note_open_session
from queueing.offers import accept, due_mails, give_mail_back, take_due_mail, take_due_pushes
from queueing.own_place import PLACE_ACTS, Page, change_place, dismiss, note_disconnection, note_presence, note_waiting
from queueing.places import Standing, standings
from queueing.rows import link_of, queue_of
from queueing.tick import tick
from queueing.tickets import join, leave, open_ticket, remove, remove_by_staff
from queueing.turns import end_by_staff, end_turn, idle_at, note_act, open_turn, others_wait_since, stay, turn_of
from queueing.words import CLOSED, End, join_said, wait_said

__all__ = (  # noqa: RUF022 - by subject
    # verbs of the queue of a robot, tickets and offers
    "queue_of", "PLACE_ACTS", "Page", "change_place", "join", "accept", "leave", "remove", "remove_by_staff",
    "take_due_pushes", "due_mails", "take_due_mail", "give_mail_back",
    # turns
    "stay", "note_act", "end_turn", "end_by_staff",
    # presence and sessions
    "note_presence", "note_waiting", "note_disconnection", "mark_disconnected", "note_open_session", "end_session",
    "Place", "dismiss",
    # jobs
    "Asker", "ask", "cancel", "RESUMED", "resume", "mark_seen", "note_answered",
    # time
    "tick",
    # reads of tickets and turns
    "open_ticket", "open_turn", "turn_of", "last_turn", "others_wait_since", "idle_at",
    "Standing", "standings", "place_and_wait", "wait_if_joined", "waiting", "waiting_people", "last_report_elsewhere",
    # ends and waits in words
    "End", "end_of_turn", "is_news", "wait_said", "join_said", "CLOSED",
    # jobs
    "job_kinds", "kinds_for", "label_of", "link_of", "offers_turns", "waits_for_staff", "job_of_form", "own_jobs",
    "unseen_jobs", "may_cancel", "may_answer", "Forecast", "forecast", "in_order", "FAULTS",
)  # fmt: skip
