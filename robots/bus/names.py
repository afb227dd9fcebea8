"""The names of all Redis keys, channels and Celery queues and tasks; nothing else makes one."""

WAKE_TASK = "robots.wake"
PROBE_TASK = "robots.probe"
# of the housekeeping worker, one queue each
HOUSEKEEPING, TICKS, PROBES, ALERTS, PUSH = "housekeeping", "ticks", "probes", "alerts", "push"
MAILS = "mails"
SOUND = "sound"  # what is watched by somebody who listens


def queue_name(slug: str, epoch: int) -> str:
    """Return the Celery queue of the owner with that epoch."""
    return f"robot.{slug}.{epoch}"


def events_channel(slug: str) -> str:
    """Return the channel of a robot's events."""
    return f"farhand:{slug}:events"


def channel_of(slug: str, what: str) -> str:
    """Return the channel of what is watched: `state`, `trace`, or the name of a demand."""
    return f"farhand:{slug}:{what.partition('.')[0]}"


def frames_of(camera: int, coarse: bool = False) -> str:
    """Return the name of a camera's stream: `frames` for the first, `frames1`, `frames2`...; `coarse`, `coarse1`..."""
    return f"{'coarse' if coarse else 'frames'}{camera or ''}"


def video_of(camera: int, coarse: bool = False) -> str:
    """Return the name of a camera's video: `video` for the first, `video1`, `video2`...; `coarsevideo`..."""
    return f"{'coarse' if coarse else ''}video{camera or ''}"


def frames_channel(slug: str, camera: int = 0, coarse: bool = False) -> str:
    """Return the channel of a camera's pictures."""
    return f"farhand:{slug}:{frames_of(camera, coarse)}"


def video_channel(slug: str, camera: int = 0, coarse: bool = False) -> str:
    """Return the channel of a camera's video."""
    return f"farhand:{slug}:{video_of(camera, coarse)}"


def state_channel(slug: str) -> str:
    """Return the channel of a robot's state packets."""
    return f"farhand:{slug}:state"


def compact_channel(slug: str) -> str:
    """Return the channel of a robot's compact states, for slow lines."""
    return f"farhand:{slug}:compact"


def stream_channel(slug: str) -> str:
    """Return the channel of a robot's byte streams."""
    return f"farhand:{slug}:stream"


def path_channel(slug: str) -> str:
    """Return the channel of the paths on which a robot begins to move."""
    return f"farhand:{slug}:path"


def trace_channel(slug: str) -> str:
    """Return the channel of a robot's wire trace, for staff."""
    return f"farhand:{slug}:trace"


def stop_channel(slug: str) -> str:
    """Return the channel that stops a robot; it passes no queue."""
    return f"farhand:{slug}:stop"


def wake_channel(slug: str) -> str:
    """Return the channel that wakes the owner; a message is lost if nobody listens."""
    return f"farhand:{slug}:wake"


def held_channel(slug: str) -> str:
    """Return the channel of keep-alives of a held motion."""
    return f"farhand:{slug}:held"


def people_channel() -> str:
    """Return the channel that says whose places in queues changed."""
    return "farhand:people"


def sessions_channel() -> str:
    """Return the channel that carries the ids of people whose session, account or clearance may have changed."""
    return "farhand:sessions"


def watch_key(slug: str, what: str) -> str:
    """Return the key that exists while somebody watches."""
    return f"farhand:{slug}:watch:{what}"


def watchers_key(slug: str) -> str:
    """Return the hash that holds how many watch a robot in each web process, and when that was counted (s)."""
    return f"farhand:{slug}:watchers"


def cheers_key(slug: str, grant: int) -> str:
    """Return the key that counts the cheers for the holder of a grant."""
    return f"farhand:{slug}:cheers:{grant}"


def web_key() -> str:
    """Return the key that exists while a web process runs; without one nobody notes who watches."""
    return "farhand:web"


def stream_key(slug: str, stream: int) -> str:
    """Return the list that holds the newest key packet of a byte stream and the deltas after it."""
    return f"farhand:{slug}:stream:{stream}"


def path_key(slug: str) -> str:
    """Return the key that holds the path on which a robot moves now."""
    return f"farhand:{slug}:path:kept"


def shot_key(slug: str, camera: int, at_ms: int | str) -> str:
    """Return the key of a live picture that has an address of its own."""
    return f"farhand:{slug}:shot:{camera}:{at_ms}"


def time_of_shot(key: bytes) -> int:
    """Return when the picture of that key was taken (ms)."""
    return int(key.decode().rpartition(":")[2])


def web_up_key() -> str:
    """Return the key that holds since when a web process runs without a break."""
    return "farhand:web-up"


def code_key(digest: str) -> str:
    """Return the key that holds for whom a one-time code is, by the code's SHA-256."""
    return f"farhand:code:{digest}"


def operator_key(slug: str, user: int) -> str:
    """Return the key that exists for a while after a person has opened the operator's stream of a robot."""
    return f"farhand:{slug}:operator:{user}"


def visitors_key(day: object, which: str) -> str:
    """Return the key that counts different addresses of a day, or that holds the salt of their hashes."""
    return f"farhand:visitors:{day}:{which}"
