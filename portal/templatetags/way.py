"""The way to driving: what the next button can do at once."""

from typing import Any

from allauth.account.internal.stagekit import get_pending_stage
from django import template
from django.template.context import RequestContext

from accounts import services
from accounts.confirm import waiting_login
from portal.live import snapshot
from queueing.models import Turn
from queueing.services import offers_turns, wait_if_joined, waiting
from robots.grants import open_grant
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.people import is_person
from robots.services.status import status_of

register = template.Library()


@register.filter
def is_soon(robot: Robot) -> bool:
    """Return whether somebody who joins now drives within seconds."""
    now = SYSTEM.now()
    state, label, _ = status_of(robot, now)
    return offers_turns(robot) and snapshot.is_soon(state, label, waiting(robot), wait_if_joined(robot, now))


@register.simple_tag(takes_context=True)
def step_on_way(context: RequestContext, robot: Robot) -> int:
    """Return the step to driving a robot at which somebody is who is signed in and has not driven it; else 0."""
    user = context["request"].user
    if (
        not user.is_authenticated
        or user.guest
        or robot.practice
        or not robot.clearance_required
        or not offers_turns(robot)
    ):
        return 0
    grant = open_grant(robot)
    if grant is not None and is_person(user, grant.holder_id):
        return 0  # a maintenance turn, in which staff drive without a clearance
    if not services.cleared(user, robot):
        return 3 if services.has_read(user, robot) else 2
    return 0 if Turn.objects.filter(robot=robot, user=user).exists() else 4


@register.simple_tag(takes_context=True)
def can_send_again(context: RequestContext) -> bool:
    """Return whether somebody signed up in this browser and has not confirmed the address in it."""
    return waiting_login(context["request"]) is not None


@register.simple_tag(takes_context=True)
def signed_up_here(context: RequestContext, confirmation: Any) -> bool:
    """Return whether the account of this confirmation was made in this browser, which waits for it to sign in.

    A program that looks at links in mails has no such session.
    """
    stage = get_pending_stage(context["request"]) if confirmation else None
    return stage is not None and bool(stage.login.user) and stage.login.user.pk == confirmation.email_address.user_id
