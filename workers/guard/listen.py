"""The loop that receives stops, keep-alives and wake-ups over pub/sub."""

import contextlib

import redis

from robots import bus
from workers.authority.lane import Lane
from workers.authority.memory import KnownGrants
from workers.guard.deadman import DeadManTimer
from workers.guard.stop import Stop
from workers.robot.owned import OwnedRobot


class Listener:
    """Passes the messages for one robot to the lanes, the stop and the dead-man timer."""

    def __init__(
        self, owned: OwnedRobot, stop: Stop, grants: KnownGrants, lanes: tuple[Lane, ...], deadman: DeadManTimer
    ) -> None:
        self._owned, self._stop, self._grants, self._lanes, self._deadman = owned, stop, grants, lanes, deadman
        self._reader: bus.Reader | None = None

    def loop(self) -> None:
        """Listen until the owner ends, or the connection breaks or is silent for long: then it is opened anew."""
        owned, slug = self._owned, self._owned.robot.slug
        wake, held, stop = bus.wake_channel(slug), bus.held_channel(slug), bus.stop_channel(slug)
        try:
            reader = self._reader = bus.Reader(owned.clock)
            reader.subscribe((stop, wake, held))
            while owned.running:
                if (message := reader.read(1.0)) is None:
                    continue
                channel, data = message
                if channel == wake:
                    for lane in self._lanes:
                        if data in (b"wake", lane.name.encode()):
                            lane.wake()
                elif channel == held:
                    with contextlib.suppress(ValueError):  # of another version; stops are heard on
                        self._deadman.hear(*bus.read_keep_alive(data))
                elif self._grants.stop_counts(bus.grant_of_stop(data)):
                    self._stop.halt("bus")
        except (redis.RedisError, OSError, ValueError):
            owned.clock.sleep(0.2)
        finally:
            self.close()

    def close(self) -> None:
        """Close the connection to Redis."""
        if self._reader is not None:
            self._reader.close()
