"""The demand for live data: a key exists while somebody watches, so that nothing else is captured and sent."""

from dataclasses import dataclass
from functools import cache

import redis

from robots.bus import names, store

WATCH_S = 4
SOME_S = 0.2  # of recordings
SLOW_S = 1.0  # a demand for one picture so often, or less often, does not make a camera capture more
# for one picture in `RARELY_S` or less often, pictures are made so often that each second one is enough
RARELY_S, RARE_S = 5.0, 2.52
RATES = ((RARELY_S, RARE_S, ".rare"), (SLOW_S, SLOW_S, ".slow"), (SOME_S, SOME_S, ".some"))  # wanted, made, name


@dataclass(frozen=True)
class Demand:
    """The demand for one camera's pictures: as JPEG or as `video`, whole or in few bytes (`coarse`).

    `every_s`: one JPEG so often is enough (s), one of `RATES`; 0: each is wanted. `key`: a key frame of the video.
    """

    camera: int = 0
    video: bool = False
    coarse: bool = False
    every_s: float = 0.0
    key: bool = False

    @property
    def name(self) -> str:
        """Return the name in the demand's Redis key; up to its dot it is the name of the channel."""
        if self.video:
            return names.video_of(self.camera, self.coarse) + (".key" if self.key else "")
        rate = next((name for _, made_s, name in RATES if made_s == self.every_s), "")
        return names.frames_of(self.camera, self.coarse) + rate


def demand_for(camera: int, every_s: float, video: bool = False, coarse: bool = False) -> Demand:
    """Return the demand of somebody who wants a picture at most once in `every_s` seconds (0: each, then as said)."""
    if every_s:
        return Demand(camera, every_s=next((made_s for wanted_s, made_s, _ in RATES if every_s >= wanted_s), 0.0))
    return Demand(camera, video, coarse)


@cache
def _possible(camera: int) -> tuple[Demand, ...]:
    each = [Demand(camera, video, coarse, 0.0, key) for coarse in (False, True)
            for video, key in ((False, False), (True, False), (True, True))]  # fmt: skip
    return (*each, *(Demand(camera, every_s=made_s) for _, made_s, _ in RATES))


def demands(slug: str, camera: int) -> frozenset[Demand]:
    """Return all demands for a camera's pictures, read in one call. Raises redis.RedisError."""
    possible = _possible(camera)
    kept = store.connection().mget(*(names.watch_key(slug, demand.name) for demand in possible))
    return frozenset(demand for demand, value in zip(possible, kept, strict=True) if value is not None)


def watch(slug: str, what: str = "frames") -> bool:
    """Note that somebody watches, for the next `WATCH_S` seconds. Return False if Redis did not answer.

    `what`: a demand's name, `state`, `compact`, `trace` or `SOUND`.
    """
    try:
        store.connection().set(names.watch_key(slug, what), 1, ex=WATCH_S)
    except (redis.RedisError, OSError):
        store.failures["watch"] += 1
        return False
    return True


def watched(slug: str, what: str = "frames") -> bool:
    """Return whether somebody watches. Raises redis.RedisError."""
    return bool(store.connection().exists(names.watch_key(slug, what)))


def end_key_demand(slug: str, camera: int, coarse: bool = False) -> None:
    """Note that a key frame of a camera's video is on its way: nobody has to ask for it any more."""
    try:
        store.connection().delete(names.watch_key(slug, Demand(camera, True, coarse, key=True).name))
    except (redis.RedisError, OSError):
        store.failures["watch"] += 1


def may_be_watched(slug: str) -> bool:
    """Return whether somebody watches; True also while Redis or all web processes are away, for then nobody knows."""
    try:
        looked = store.connection().exists(*(names.watch_key(slug, what) for what in ("frames", "state")))
        return bool(looked) or not store.connection().exists(names.web_key())
    except (redis.RedisError, OSError):
        return True
