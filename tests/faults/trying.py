"""A worker that says each time it has tried to take its robot, so that a test sees that those who wait have looked.

``python -m tests.faults.trying -- celery arguments``
"""

import os
import sys

TRIED = "tried to take the robot\n"


def main():
    import django

    os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")
    django.setup()
    from workers.safety.lease import OwnerLease

    inner = OwnerLease._try

    def tried(lease):
        taken = inner(lease)
        os.write(sys.__stdout__.fileno(), TRIED.encode())
        return taken

    OwnerLease._try = tried
    from celery.__main__ import main as celery

    sys.argv = ["celery", *sys.argv[2:]]
    celery()


if __name__ == "__main__":
    main()
