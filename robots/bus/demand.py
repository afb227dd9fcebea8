"""Who wants what: a key exists while somebody watches, so that only what is wanted is captured and sent."""

from typing import NamedTuple

import redis

from robots.bus import names, store

WATCH_S = 4
SLOW_S = 1.0  # a viewer who wants a picture only so often, or less often, does not make a camera capture more
RARELY_S, RARE_S = 5.0, 2.52  # one who wants a picture in 5 s or less often is given the second of pictures so often
SOME_S = 0.2  # of recordings


def watched_as(camera: int, every_s: float, video: bool = False, coarse: bool = False) -> str:
    """Return what is watched by somebody who wants a camera's picture at most once in `every_s` seconds.

    `video`, `coarse`: as video, or in few bytes, where each picture is wanted.
    """
    if every_s:
        rates = ((RARELY_S, ".rare"), (SLOW_S, ".slow"), (SOME_S, ".some"))
        return names.frames_of(camera) + next((name for least_s, name in rates if every_s >= least_s), "")
    return names.video_of(camera, coarse) if video else names.frames_of(camera, coarse)


def watch(slug: str, what: str = "frames") -> bool:
    """Note that somebody watches, for the next `WATCH_S` seconds. Return False if Redis did not answer."""
    try:
        store.connection().set(names.watch_key(slug, what), 1, ex=WATCH_S)
    except (redis.RedisError, OSError):
        store.failures["watch"] += 1
        return False
    return True


def watched(slug: str, what: str = "frames") -> bool:
    """Return whether somebody watches. Raises redis.RedisError."""
    return bool(store.connection().exists(names.watch_key(slug, what)))


class Wanted(NamedTuple):
    """What somebody wants of a camera, whole and coarse: each picture, video, a key picture of it.

    `some`: one picture in `SOME_S` seconds; `now_and_then`: one in `SLOW_S` seconds; `rarely`: one in `RARE_S` seconds.
    """

    each: bool = False
    video: bool = False
    key: bool = False
    coarse: bool = False
    coarse_video: bool = False
    coarse_key: bool = False
    some: bool = False
    now_and_then: bool = False
    rarely: bool = False


def how_watched(slug: str, camera: int) -> Wanted:
    """Return what somebody wants of a camera. Raises redis.RedisError."""
    streams = [
        name(camera, coarse) for coarse in (False, True) for name in (names.frames_of, names.video_of, names.key_of)
    ]
    streams += [watched_as(camera, SOME_S), watched_as(camera, SLOW_S), watched_as(camera, RARELY_S)]
    return Wanted(
        *(found is not None for found in store.connection().mget(*(names.watch_key(slug, name) for name in streams)))
    )


def key_comes(slug: str, camera: int, coarse: bool = False) -> None:
    """Note that a key picture of a camera's video is on its way: nobody has to ask for it any more."""
    try:
        store.connection().delete(names.watch_key(slug, names.key_of(camera, coarse)))
    except (redis.RedisError, OSError):
        store.failures["watch"] += 1


def may_be_watched(slug: str) -> bool:
    """Return whether somebody watches; True also while Redis or all web processes are away, for then nobody knows."""
    try:
        looked = store.connection().exists(*(names.watch_key(slug, what) for what in ("frames", "state")))
        return bool(looked) or not store.connection().exists(names.web_key())
    except (redis.RedisError, OSError):
        return True
