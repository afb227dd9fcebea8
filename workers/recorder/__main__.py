"""`python -m workers.recorder`: records turns and jobs of the robots whose page in the admin says so."""

import fcntl
import logging
import os
import signal
import sys
import threading
from pathlib import Path

os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")

import django

NICE = 5  # a busy machine moves robots first


def main() -> None:
    """Record until SIGTERM."""
    django.setup()
    from django.conf import settings  # noqa: PLC0415 - after the set-up

    from robots.kit.priority import stand_back  # noqa: PLC0415
    from workers.recorder.recorder import Recorder, wait_for_lock  # noqa: PLC0415

    stop = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stop.set())
    stand_back(NICE)
    run = Path(settings.VAR) / "run"
    run.mkdir(parents=True, exist_ok=True)
    lock = os.open(run / "recorder.lock", os.O_RDWR | os.O_CREAT, 0o600)

    def take() -> bool:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True

    if wait_for_lock(stop.is_set, take):
        Recorder().run(stop.is_set)
    logging.shutdown()
    sys.exit(0)


if __name__ == "__main__":
    main()
