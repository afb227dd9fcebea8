"""Functions of other apps that run after staff have added a robot on the admin page."""

from collections.abc import Callable

from robots.models import Robot

Load = Callable[[Robot], str]
AFTER_ADDING: list[Load] = []


def after_adding(load: Load) -> Load:
    """Call this for each robot that staff add; they are told what it returns, if anything."""
    AFTER_ADDING.append(load)
    return load
