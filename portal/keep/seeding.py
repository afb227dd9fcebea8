"""Fills an empty database: robots, questions, survey, administrator."""

import secrets

from allauth.account.models import EmailAddress
from django.contrib.auth.models import Group, Permission
from django.db import transaction

from accounts.models import User
from accounts.services import load_bank
from operatorlog.models import SurveyQuestion
from operatorlog.services import begin_first
from queueing.services import queue_of
from robots.kit import description
from robots.kit.clock import SYSTEM
from robots.models import Records, Robot
from robots.services import twin_of
from robots.services.programs import load_gallery
from robots.states import Cycle

SURVEY = (
    ("How easy was it to do with the robot what you wanted?", "scale", "", "hard", "easy"),
    ("Did it feel as if you were there?", "scale", "", "not at all", "very much"),
    ("Did you feel that you moved a real thing?", "choice", "Yes\nNo\nNot sure", "", ""),
    ("What would you use a robot on the web for?", "text", "", "", ""),
)
LAYOUT = "Pleasing and easy to use\nEasy to use, not pleasing\nHard to use"
WATCHED = "About a minute\nUp to 20 minutes\nUp to two hours\nLonger"
JOB_SURVEY = (  # as in the paper of the iRat
    ("What do you think of the layout of the page?", "choice", LAYOUT, "", ""),
    ("How did the video look?", "choice", "Smooth\nChoppy\nThere was none", "", ""),
    ("How long did you watch the robot?", "choice", WATCHED, "", ""),
    ("What should the robot do better?", "text", "", "", ""),
)
SHIPPED = ("mercury", "pa10", "irat", "srv1", "puma")
PRACTISED = "mercury"  # the robot of which a demo has a twin for practice; each costs a worker
MODERATORS = ("view_entry", "change_entry", "view_turn", "view_surveyresponse", "view_find", "change_find")


def add_robot(driver: str) -> Robot:
    """Add a simulated robot of a driver, switched on, with the settings of its folder."""
    about = description.load(driver)
    robot = Robot.objects.create(
        slug=about.get("slug", driver), name=about["name"], tagline=about["tagline"], driver=driver,
        address=f"sim:{driver}", enabled=True, cycle=Cycle.HANDOVER,
        microphone=about.get("microphone", {}).get("address", ""), records=Records.WORK,
    )  # fmt: skip
    queue_of(robot)
    load_bank(robot)
    load_gallery(robot, SYSTEM.now())
    begin_first(robot, SYSTEM.now())
    return robot


@transaction.atomic
def seed() -> str | None:
    """Add what is missing. Return a new admin password if there was no administrator."""
    if not Robot.objects.exists():
        for name in SHIPPED:
            robot = add_robot(name)
            if name == PRACTISED:
                queue_of(twin_of(robot))
    if not SurveyQuestion.objects.exists():
        after = SurveyQuestion.After
        told = [(after.TURN, one) for one in SURVEY] + [(after.JOB, one) for one in JOB_SURVEY]
        for position, (what, (prompt, kind, options, low, high)) in enumerate(told):
            SurveyQuestion.objects.create(
                prompt=prompt, kind=kind, options=options, low_label=low, high_label=high, position=position, after=what
            )
    group, made = Group.objects.get_or_create(name="Moderators")
    if made:
        group.permissions.set(Permission.objects.filter(codename__in=MODERATORS))
    if User.objects.filter(is_superuser=True).exists():
        return None
    password = secrets.token_urlsafe(12)
    admin = User.objects.create_superuser("admin", "admin@localhost.localdomain", password)
    # nobody reads mail there, and without this the first sign-in would wait for a confirmation
    EmailAddress.objects.create(user=admin, email=admin.email, verified=True, primary=True)
    return password
