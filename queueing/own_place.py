"""Acts of people on their own place, the same from every page: join, accept, leave, stay."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from queueing.errors import NotYourTurn, QueueError
from queueing.offers import accept
from queueing.tickets import join, leave
from queueing.turns import stay
from robots.models import Robot


@dataclass(frozen=True)
class Page:
    """The page from which a person acts.

    `session`: the key of its session; `away`: not the robot's own page; `classic`: the console without scripts.
    """

    session: str = ""
    away: bool = False
    classic: bool = False


def _stay(robot: Robot, user: Any, now: datetime) -> None:
    if not stay(robot, user, now):
        raise NotYourTurn("Your turn on this robot is over.")


PLACE_ACTS: dict[str, Callable[[Robot, Any, datetime, Page], object]] = {
    "join": lambda robot, user, now, page: join(robot, user, now, classic=page.classic),
    "accept": lambda robot, user, now, page: accept(robot, user, now, away=page.away, session=page.session),
    "leave": lambda robot, user, now, _: leave(robot, user, now),
    "stay": lambda robot, user, now, _: _stay(robot, user, now),
}


def change_place(act: str, robot: Robot, user: Any, now: datetime, page: Page) -> None:
    """Carry out one of `PLACE_ACTS`. Raises QueueError with a sentence for the person, also if there is no such act."""
    if act not in PLACE_ACTS:
        raise QueueError("That request is unknown; reload the page.")
    PLACE_ACTS[act](robot, user, now, page)
