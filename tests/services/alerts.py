"""Staff who are told of alerts, and the rounds of the task that tells them."""

import pytest
from allauth.account.models import EmailAddress

from portal.web.alerts.following import follow
from portal.web.alerts.sending import send_due
from robots.models import Robot


@pytest.fixture(autouse=True)
def staffed(people, robot, owned, settings):
    """Kim keeps robots and has a confirmed address; mod, who moderates, is told nothing."""
    for name in ("kim", "mod", "ada"):
        EmailAddress.objects.create(user=people[name], email=f"{name}@example.org", verified=True, primary=True)
    settings.SITE_ADDRESS = "https://robots.example.org"
    return people["kim"]


def stop(robot, latched=True):
    Robot.objects.filter(pk=robot.pk).update(stop_latched=latched)


def rounds(clock, minutes, each_s=30):
    """Let the task run as the schedule lets it."""
    for _ in range(int(minutes * 60 / each_s)):
        follow(clock.now())
        send_due(clock.now())
        clock.go(each_s)
