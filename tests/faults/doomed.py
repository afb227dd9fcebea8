"""A worker that is killed (or frozen) by itself before it sends Mercury a motion of a command.

``python -m tests.faults.doomed SIGNAL -- celery arguments``
"""

import os
import signal
import sys
import time  # noqa: TID251 - a pause of a process of its own


def _end(number):
    os.kill(os.getpid(), number)
    time.sleep(0.2)  # the signal may be taken by another thread, a moment later


def _arm(number):
    """Wrap the one function at which this worker is to die."""
    from robots.kit.drivers.mercury.protocol import Instruction
    from robots.kit.drivers.serial_line import SerialLine
    from robots.models import Command

    inner = SerialLine._send

    def wrapped(line, what, *rest, **kwargs):
        # only commands have a row; homing at handover has none
        if what.id == Instruction.MOVE_XYZ and Command.objects.filter(ended_at__isnull=True).exists():
            _end(number)
        return inner(line, what, *rest, **kwargs)

    SerialLine._send = wrapped


def main():
    import django

    number = getattr(signal, sys.argv[1])
    os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")
    django.setup()
    _arm(number)
    from celery.__main__ import main as celery

    sys.argv = ["celery", *sys.argv[3:]]
    celery()


if __name__ == "__main__":
    main()
