"""Two byte streams of a robot's objects: where they are, and how that is known.

`objects` has the packets of `robots.kit.contract.objects`: nothing is sent of an object that rests or is carried.
`beliefs` is JSON, key packets alone, sent when a belief changes: by name `how` and `at_ms`, a `note` of them all, and
how far the `goals` are, where there are any.
"""

from collections.abc import Callable, Mapping
from typing import Any

import msgspec

from robots.kit.arms.beliefs import Snapshot
from robots.kit.arms.objects import ObjectTable
from robots.kit.contract.objects import KnownObjects, Placed
from robots.kit.contract.streams import Stream

OBJECTS, BELIEFS = "objects", "beliefs"
STREAMS = (Stream(OBJECTS, "application/x-farhand-objects"), Stream(BELIEFS, "application/json"))
Send = Callable[[str, bytes, bool], bool]


class ObjectStreams:
    """Sends snapshots; its caller has a lock. `send(name, data, key)` returns whether the next must be a key packet."""

    def __init__(self, table: ObjectTable, send: Send) -> None:
        self._table, self._send = table, send
        self._known = KnownObjects(table.box)
        self._key = True

    def renew(self) -> None:
        """Send everything next: whoever listened before is gone."""
        self._key = True

    def tell(self, now: Snapshot, goals: Mapping[str, Any] | None = None) -> None:
        """Send what has changed since the last snapshot."""
        objects: dict[int, Placed] = {}
        for name, belief in now.beliefs.items():
            if (placed := belief.placed) is not None:
                objects[self._table.objects[name].number] = placed
        data = self._known.key(objects) if self._key else self._known.delta(objects)
        if data or self._key:
            self._key = self._send(OBJECTS, data, self._key)
        told = {name: {"how": one.how, "at_ms": one.at_ms} for name, one in now.beliefs.items()}
        more = {"goals": goals} if goals else {}
        self._send(BELIEFS, msgspec.json.encode({"objects": told, "note": now.note, **more}), True)
