"""What other apps do when staff have added a robot on the admin page."""

from collections.abc import Callable

from robots.models import Robot

Load = Callable[[Robot], str]
ADDED: list[Load] = []


def on_added(load: Load) -> Load:
    """Call this for each robot that staff add; they are told what it returns, if anything."""
    ADDED.append(load)
    return load
