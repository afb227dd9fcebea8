"""Give a person a turn on the demo's Mercury arm; print the key of their session and the number of the turn."""

import os
import sys
import time

import django

os.environ["DJANGO_SETTINGS_MODULE"] = "portal.settings"
django.setup()

from django.contrib.auth import BACKEND_SESSION_KEY, HASH_SESSION_KEY, SESSION_KEY, get_user_model  # noqa: E402
from django.contrib.sessions.backends.db import SessionStore  # noqa: E402

from accounts.models import Clearance  # noqa: E402
from queueing import services as queue  # noqa: E402
from queueing.models import Ticket  # noqa: E402
from robots.kit.clock import SYSTEM  # noqa: E402
from robots.models import Robot  # noqa: E402

robot = Robot.objects.get(slug="mercury")
ada = get_user_model().objects.create_user("ada", "ada@example.org", "correct horse 42")
Clearance.objects.create(user=ada, robot=robot, granted_at=SYSTEM.now())
session = SessionStore()
session[SESSION_KEY], session[HASH_SESSION_KEY] = str(ada.pk), ada.get_session_auth_hash()
session[BACKEND_SESSION_KEY] = "accounts.backends.ConstantTimeBackend"
session.save()
queue.join(robot, ada, SYSTEM.now())
until = time.monotonic() + 60
while Ticket.objects.get().state != "offered" and time.monotonic() < until:
    queue.note_waiting(ada, SYSTEM.now())
    time.sleep(0.1)
turn = queue.accept(robot, ada, SYSTEM.now())
sys.stdout.write(f"{session.session_key} {turn.pk}\n")
