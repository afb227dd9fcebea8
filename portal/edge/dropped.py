"""Counts sockets that this process ends or refuses by rule; the log says how many, once a minute at most."""

import asyncio
import logging
from collections import Counter

log = logging.getLogger(__name__)
TELL_S = 60.0
dropped: Counter[str] = Counter()  # by reason, since the process began
_told: Counter[str] = Counter()
_waits: set[int] = set()  # event loops in which the next line of the log waits


def drop(reason: str) -> None:
    """Count a socket; called in an event loop."""
    dropped[reason] += 1
    loop = asyncio.get_running_loop()
    if id(loop) not in _waits:
        _waits.add(id(loop))
        loop.call_later(TELL_S, _tell, id(loop))


def _tell(loop: int) -> None:
    """Log what was counted since the last time."""
    _waits.discard(loop)
    new = dropped - _told
    _told.update(new)
    if new:
        log.warning(
            "sockets ended or refused: %s", ", ".join(f"{count} {reason}" for reason, count in sorted(new.items()))
        )
