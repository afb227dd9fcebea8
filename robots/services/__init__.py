"""The verbs of robots, by subject. One verb is one function.

Pages, sockets, admin and tasks call these functions, which check permissions, open the transaction, write rows and
send events. Services create rows; only the owner changes them.
"""

from robots.grants import end_grant, open_grant, start_grant
from robots.services.clicks import newest_still, resolve
from robots.services.commands import START_S, Issued, RobotOffline, issue, need_worker, next_seq, staff_command
from robots.services.configuring import configure, reset_settings, settings_to_reset
from robots.services.incidents import close_incident
from robots.services.lockout import end_maintenance, lift_lock_out, lock_out, set_enabled, start_maintenance
from robots.services.outages import note_outages
from robots.services.recordings import choose_of_the_day, remove_recording, take_down
from robots.services.stopping import StopShown, asked_since_stop, may_stop, release_stop, stop, stop_shown
from robots.services.twins import add_twin, twin_of
from robots.services.usage import forget_old_usage, note_online, note_usage, slot_of

__all__ = (  # noqa: RUF022 - by subject
    # grants, which permit somebody to move a robot
    "end_grant", "open_grant", "start_grant",
    # commands
    "START_S", "Issued", "RobotOffline", "issue", "need_worker", "newest_still", "next_seq", "resolve", "staff_command",
    # settings
    "configure", "reset_settings", "settings_to_reset",
    # the stop
    "StopShown", "asked_since_stop", "may_stop", "release_stop", "stop", "stop_shown",
    # the lock-out, the switch, the maintenance turn, incidents
    "lift_lock_out", "lock_out", "set_enabled", "start_maintenance", "end_maintenance", "close_incident",
    "note_outages",
    # pictures and recordings
    "choose_of_the_day", "remove_recording", "take_down",
    # practice
    "add_twin", "twin_of",
    # counters of use
    "forget_old_usage", "note_online", "note_usage", "slot_of",
)  # fmt: skip
