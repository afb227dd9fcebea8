"""Fills an empty database: robots, questions, survey, administrator."""

import secrets

from allauth.account.models import EmailAddress
from django.contrib.auth.models import Group, Permission
from django.db import transaction
from django.utils.translation import gettext_noop

from accounts.models import User
from accounts.services import load_bank
from operatorlog.models import SurveyQuestion
from operatorlog.services import begin_first
from queueing.services import queue_of
from robots.kit import description
from robots.kit.clock import SYSTEM
from robots.kit.contract.tidying import TIDY_S, Tidy
from robots.models import Records, Robot
from robots.services import twin_of
from robots.services.programs import load_gallery
from robots.states import Cycle

SURVEY = (  # rows of the database, which pages translate
    (gettext_noop("How easy was it to do with the robot what you wanted?"), "scale", (),
     gettext_noop("hard"), gettext_noop("easy")),
    (gettext_noop("Did it feel as if you were there?"), "scale", (),
     gettext_noop("not at all"), gettext_noop("very much")),
    (gettext_noop("Did you feel that you moved a real thing?"), "choice",
     (gettext_noop("Yes"), gettext_noop("No"), gettext_noop("Not sure")), "", ""),
    (gettext_noop("What would you use a robot on the web for?"), "text", (), "", ""),
)  # fmt: skip
LAYOUT = (
    gettext_noop("Pleasing and easy to use"), gettext_noop("Easy to use, not pleasing"), gettext_noop("Hard to use"),
)  # fmt: skip
WATCHED = (
    gettext_noop("About a minute"), gettext_noop("Up to 20 minutes"), gettext_noop("Up to two hours"),
    gettext_noop("Longer"),
)  # fmt: skip
VIDEO = (gettext_noop("Smooth"), gettext_noop("Choppy"), gettext_noop("There was none"))
JOB_SURVEY = (  # as in the paper of the iRat
    (gettext_noop("What do you think of the layout of the page?"), "choice", LAYOUT, "", ""),
    (gettext_noop("How did the video look?"), "choice", VIDEO, "", ""),
    (gettext_noop("How long did you watch the robot?"), "choice", WATCHED, "", ""),
    (gettext_noop("What should the robot do better?"), "text", (), "", ""),
)
SHIPPED = ("mercury", "pa10", "irat", "srv1", "puma")
# of a demo's arms between two turns (s): some 20 for each of up to five objects, and a move that needs 30 still begins
TIDIES_S = 150.0
PRACTISED = "mercury"  # the robot of which a demo has a twin for practice; each costs a worker
MODERATORS = (
    "view_entry", "change_entry", "view_turn", "view_surveyresponse", "view_find", "change_find",
    "view_hidingreason", "add_hidingreason", "change_hidingreason",
)  # fmt: skip


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
            if robot.spec().capability(Tidy) is not None:  # a newcomer finds the table as the orientation shows it
                robot.settings = {TIDY_S: TIDIES_S}
                robot.save(update_fields=["settings"])
            if name == PRACTISED:
                queue_of(twin_of(robot))
    if not SurveyQuestion.objects.exists():
        after = SurveyQuestion.After
        told = [(after.TURN, one) for one in SURVEY] + [(after.JOB, one) for one in JOB_SURVEY]
        for position, (what, (prompt, kind, options, low, high)) in enumerate(told):
            SurveyQuestion.objects.create(
                prompt=prompt, kind=kind, options="\n".join(options), low_label=low, high_label=high,
                position=position, after=what,
            )  # fmt: skip
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
