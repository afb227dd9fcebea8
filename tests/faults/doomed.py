"""A worker that is killed (or frozen) by itself at a labelled point of a command's life.

``python -m tests.faults.doomed LABEL SIGNAL -- celery arguments``
"""

import os
import signal
import sys
import threading
import time

LABELS = (
    "before_claim", "after_claim", "before_send", "after_send", "after_ack",
    "in_motion", "before_finish", "after_finish",
)  # fmt: skip


def _end(number):
    os.kill(os.getpid(), number)
    time.sleep(0.2)  # the signal may be taken by another thread, a moment later


def _arm(label, number):
    """Wrap the one function at which this worker is to die."""
    from robots.drivers.irat.line import IratLine
    from robots.drivers.irat.protocol import Velocity
    from robots.drivers.mercury.line import HostLine
    from robots.drivers.mercury.protocol import Instruction
    from robots.drivers.pa10.line import ArmLine
    from robots.models import Command, Robot
    from workers.commands import claim, finish

    def before(owner, name, when=lambda *a: True):
        inner = getattr(owner, name)

        def wrapped(*args, **kwargs):
            if when(*args):
                _end(number)
            return inner(*args, **kwargs)

        setattr(owner, name, wrapped)

    def after(owner, name, when=lambda *a: True, later=0.0):
        inner = getattr(owner, name)

        def wrapped(*args, **kwargs):
            result = inner(*args, **kwargs)
            if when(*args):
                threading.Thread(target=lambda: (time.sleep(later), _end(number))).start() if later else _end(number)
            return result

        setattr(owner, name, wrapped)

    def of_a_turn(*args):
        """Only commands have a row; homing at handover has none."""
        return Command.objects.exclude(ended_at__isnull=False).exists()

    def is_move(line, what, *rest):
        if isinstance(what, Velocity):
            return what != Velocity(0.0, 0.0) and of_a_turn()
        move = what[:1] == b"j" if isinstance(what, bytes) else what.id == Instruction.MOVE_XYZ
        return move and of_a_turn()

    sends = {"mercury": (HostLine, "_send"), "pa10": (ArmLine, "_send"), "irat": (IratLine, "drive")}
    line = sends[Robot.objects.get(slug=os.environ["FARHAND_ROBOT"]).driver]

    {
        "before_claim": lambda: before(claim, "claim"),
        "after_claim": lambda: after(claim, "claim"),
        "before_send": lambda: before(*line, is_move),
        "after_send": lambda: after(*line, is_move),
        "after_ack": lambda: before(finish, "advance", lambda c, state, now: state == "acknowledged"),
        "in_motion": lambda: after(finish, "advance", lambda c, state, now: state == "acknowledged", 0.15),
        "before_finish": lambda: before(finish, "finish"),
        "after_finish": lambda: after(finish, "finish"),
    }[label]()


def main():
    import django

    label, number = sys.argv[1], getattr(signal, sys.argv[2])
    os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")
    django.setup()
    _arm(label, number)
    from celery.__main__ import main as celery

    sys.argv = ["celery", *sys.argv[4:]]
    celery()


if __name__ == "__main__":
    main()
