"""One object of a kind for each event loop: what its sockets share."""

import asyncio
from collections.abc import Callable
from functools import cache
from typing import TypeVar

T = TypeVar("T")


def of_loop(make: Callable[[], T]) -> Callable[[], T]:
    """Return a function that returns the object of the running event loop, made when it is first asked for."""
    made = cache(lambda loop: make())
    return lambda: made(asyncio.get_running_loop())
