"""Waits and lengths of time in words. The pages' scripts use the same words (`frontend/src/words.ts`)."""

from dataclasses import dataclass
from math import ceil

from queueing.models import PlaceEnd
from robots.states import GrantEnd

CLOSED = ("fault", "stopped", "offline", "locked_out")  # states in which nobody knows when a turn begins
UNKNOWN = "the wait is not known now"


def wait_words(wait: tuple[int, int] | None) -> str:
    """Return the least and greatest wait (s) in words; None stands for an unknown wait."""
    if wait is None:
        return UNKNOWN
    low, high = wait
    if high < 10:
        return "any moment now"
    if high < 60:
        return "less than a minute"
    if low < 60:
        return f"at most {_rounded(high)}"
    near, far = _rounded(low), _rounded(high)
    return f"about {far}" if near == far else f"about {near} to {far}"


def wait_said(wait: tuple[int, int] | None) -> str:
    """Return the same as a sentence."""
    words = wait_words(wait)
    return "The wait is not known now; your place is kept." if wait is None else f"{words[:1].upper()}{words[1:]}."


def join_said(state: str, free: bool, wait: tuple[int, int] | None) -> str:
    """Return how long somebody who joins now would wait for a robot in that state; empty if it is closed."""
    if state in CLOSED:
        return ""
    if free:
        return "Free now"
    return f"Your wait: {'not known now' if wait is None else wait_words(wait)}"


def _rounded(seconds: int) -> str:
    return f"{ceil(seconds / 60)} min" if seconds < 5400 else f"{ceil(seconds / 3600)} h"


@dataclass(frozen=True)
class End:
    """The words of one kind of end; `{used}`, `{idle}` and others stand for lengths of time."""

    why: str
    credited: str
    next: str


WHOLE = "In the fair share of turns, {used} count as your use of the robot."
CUT = "Only the {used} that you had count as your use; the rest of it costs you nothing. No place is kept for you."
FREE = "It costs you nothing."
JOIN = "You can join the queue again."
LATER = "You can join the queue now; turns go on when staff open the robot again."
ASK = "You cannot join the queue until staff allow it; ask them."

TURN_ENDS: dict[GrantEnd, End] = {
    GrantEnd.FINISHED: End("It was ended.", WHOLE, JOIN),
    GrantEnd.FAILED: End("The robot failed.", CUT, JOIN),
    GrantEnd.TIME_UP: End("Its time was up.", WHOLE, JOIN),
    GrantEnd.HOLDER: End("You ended it.", WHOLE, JOIN),
    GrantEnd.STAFF: End("Staff ended it.", CUT, JOIN),
    GrantEnd.ABSENT: End("The robot's page had no connection to the portal for {reconnect}.", CUT, JOIN),
    GrantEnd.IDLE: End("Nothing was done for {idle} while others waited.", CUT, JOIN),
    GrantEnd.SILENT: End("The console without scripts sent nothing for {silent}.", CUT, JOIN),
    GrantEnd.SIGNED_OUT: End("You were signed out, here or in another browser.", CUT, JOIN),
    GrantEnd.UNFIT: End("Your account or your clearance for this robot was withdrawn.", CUT, ASK),
    GrantEnd.STOPPED: End("The robot was stopped.", CUT, JOIN),
    GrantEnd.LOCKED_OUT: End("Staff closed the robot to everybody.", CUT, LATER),
    GrantEnd.SWITCHED_OFF: End(
        "Staff switched the robot off.", CUT, "You can join the queue when the robot is switched on again."
    ),
    GrantEnd.OWNER_LOST: End("The robot's program was interrupted.", CUT, JOIN),
    GrantEnd.PREEMPTED: End("Staff needed the robot.", CUT, JOIN),
    GrantEnd.RESTORED: End("The portal was restored from a backup.", CUT, JOIN),
}
PLACE_ENDS: dict[PlaceEnd, End] = {
    PlaceEnd.NO_ANSWER: End("You did not take control in time, so your place is gone.", FREE, JOIN),
    PlaceEnd.AWAY: End("You were away for too long, so your place is gone.", FREE, JOIN),
    PlaceEnd.LEFT: End("You left the queue.", FREE, JOIN),
    PlaceEnd.REMOVED: End("Staff took you out of the queue.", FREE, JOIN),
    PlaceEnd.SUSPENDED: End("Your account was switched off.", FREE, ASK),
    PlaceEnd.UNCLEARED: End("Your clearance for this robot was withdrawn.", FREE, ASK),
    PlaceEnd.DELETED: End("Your account was deleted.", FREE, ASK),
}
OWN_WISH = (GrantEnd.HOLDER, PlaceEnd.LEFT)  # the person chose this end, so no page explains it
