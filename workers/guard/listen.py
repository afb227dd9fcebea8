"""The loop that receives stops, keep-alives and wake-ups over pub/sub."""

import contextlib

import redis

from robots import bus
from workers.authority.lane import Lane
from workers.authority.memory import KnownGrants
from workers.guard.deadman import DeadManTimer
from workers.guard.stop import Stop
from workers.robot.owned import OwnedRobot

PING_S, SILENT_S = 2.0, 7.0  # Redis answers each ping; after this silence it is taken for gone


class Listener:
    """Passes what is published for one robot to the lanes, the stop and the dead-man timer."""

    def __init__(
        self, owned: OwnedRobot, stop: Stop, grants: KnownGrants, lanes: tuple[Lane, ...], deadman: DeadManTimer
    ) -> None:
        self._owned, self._stop, self._grants, self._lanes, self._deadman = owned, stop, grants, lanes, deadman
        self._pubsub: redis.client.PubSub | None = None

    def loop(self) -> None:
        """Listen until the owner ends, or the connection breaks or is silent for long: then it is opened anew."""
        owned, slug = self._owned, self._owned.robot.slug
        wake, held, stop = bus.wake_channel(slug), bus.held_channel(slug), bus.stop_channel(slug)
        try:
            self._pubsub = bus.listener().pubsub(ignore_subscribe_messages=True)
            self._pubsub.subscribe(stop, wake, held)
            heard = asked = owned.clock.monotonic()
            while owned.running and owned.clock.monotonic() - heard < SILENT_S:
                message = self._pubsub.get_message(timeout=1.0)
                now = owned.clock.monotonic()
                if message is not None:
                    heard = now
                if now - asked >= PING_S:
                    asked = now
                    self._pubsub.ping()
                if message is None or message["type"] != "message":
                    continue
                channel = message["channel"].decode()
                if channel == wake:
                    for lane in self._lanes:
                        if message["data"] in (b"wake", lane.name.encode()):
                            lane.wake()
                elif channel == held:
                    with contextlib.suppress(ValueError):  # of another version; stops are heard on
                        self._deadman.hear(*bus.read_keep_alive(message["data"]))
                elif self._grants.stop_counts(bus.grant_of_stop(message["data"])):
                    self._stop.halt("bus")
        except (redis.RedisError, OSError, ValueError):
            owned.clock.sleep(0.2)
        finally:
            self.close()

    def close(self) -> None:
        """Close the connection to Redis."""
        if self._pubsub is not None:
            with contextlib.suppress(OSError, redis.RedisError):
                self._pubsub.close()
