"""Fills an empty database: robots, questions, survey, administrator."""

import secrets
import tomllib

from django.contrib.auth.models import Group, Permission
from django.db import transaction

from accounts.models import Choice, Question, User
from operatorlog.models import SurveyQuestion
from queueing.services import queue_of
from robots import description
from robots.clock import SYSTEM
from robots.models import Program, Records, Robot
from robots.states import Cycle

SURVEY = (
    ("How easy was it to do with the robot what you wanted?", "scale", "", "hard", "easy"),
    ("Did it feel as if you were there?", "scale", "", "not at all", "very much"),
    ("Do you believe that the robot is real?", "choice", "Yes\nNo\nNot sure", "", ""),
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
SHIPPED = ("mercury", "pa10", "irat")
MODERATORS = ("view_entry", "change_entry", "view_turn", "view_surveyresponse")


def seed_clearance(robot: Robot) -> int:
    """Fill a question bank that is empty or from before questions had topics. Return how many were added."""
    mine = Question.objects.filter(robot=robot)
    if mine.exists() and not mine.filter(topic="").exists():
        return 0
    added = 0
    for one in tomllib.loads(description.text_of(robot.driver, "clearance.toml"))["question"]:
        about = {name: one[name] for name in ("topic", "section", "paragraph") if name in one}
        if mine.filter(text=one["text"]).update(**about) if about else mine.filter(text=one["text"]).exists():
            continue
        question = Question.objects.create(
            robot=robot, text=one["text"], explanation=one.get("explanation", ""), **about
        )
        for number, text in enumerate(one["choices"]):
            Choice.objects.create(question=question, text=text, correct=number == 0)
        added += 1
    return added


def add_robot(driver: str) -> Robot:
    """Add a simulated robot of a driver, switched on, with the settings of its folder."""
    about = description.load(driver)
    robot = Robot.objects.create(
        slug=about.get("slug", driver), name=about["name"], tagline=about["tagline"], driver=driver,
        address=f"sim:{driver}", enabled=True, cycle=Cycle.HANDOVER,
        microphone=about.get("microphone", {}).get("address", ""), records=Records.WORK,
    )  # fmt: skip
    queue_of(robot)
    seed_clearance(robot)
    for name, text in description.programs_of(driver):
        Program.objects.create(robot=robot, name=name, text=text, approved=True, changed_at=SYSTEM.now())
    return robot


@transaction.atomic
def seed() -> str | None:
    """Add what is missing. Return a new admin password if there was no administrator."""
    if not Robot.objects.exists():
        for name in SHIPPED:
            add_robot(name)
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
    User.objects.create_superuser("admin", "admin@localhost.localdomain", password)
    return password
