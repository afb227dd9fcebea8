"""Keeps alerts: a need begins one, its end ends it, and each is told once, whichever process finds it.

Each step is one conditional UPDATE, and the messages are made in its transaction. A need that comes and goes again is
one alert: it is over only after the robot has been well for a while, and for longer where it just had the same.
"""

from collections.abc import Iterable
from datetime import datetime, timedelta
from typing import Any

from allauth.account.models import EmailAddress
from django.conf import settings
from django.contrib.auth import get_user_model
from django.db import IntegrityError, transaction

from portal.web.alerts.models import Alert, AlertChoice, AlertMessage, may_be_told
from portal.web.alerts.needs import Need, needs
from robots.wall_clock import FIRST

WELL = timedelta(minutes=2)
WELL_AGAIN = timedelta(minutes=30)  # where another alert of the same kind ended within `LATELY`
LATELY = timedelta(hours=2)
KEPT = timedelta(days=400)


def follow(now: datetime) -> None:
    """Compare what robots need with the open alerts, and prepare the messages to staff."""
    found = needs(now)
    known = {(one.robot_id, one.kind, one.subject): one for one in Alert.objects.filter(ended_at=None)}
    for key, need in found.items():
        _lasts(known.get(key) or _begin(need, now), need, now)
    for key, alert in known.items():
        if key not in found:
            _clear(alert, now)
    Alert.objects.filter(ended_at__gte=FIRST, ended_at__lt=now - KEPT).delete()


def _begin(need: Need, now: datetime) -> Alert:
    try:
        with transaction.atomic():
            return Alert.objects.create(
                robot=need.robot, kind=need.kind, subject=need.subject, text=need.text, seen_at=now
            )
    except IntegrityError:  # another process was quicker
        return Alert.objects.get(robot=need.robot, kind=need.kind, subject=need.subject, ended_at=None)


def _lasts(alert: Alert, need: Need, now: datetime) -> None:
    if alert.clear_since is not None:
        Alert.objects.filter(pk=alert.pk, ended_at=None).update(clear_since=None)
    if alert.told_at is not None or (now - alert.seen_at).total_seconds() < need.after_s:
        return
    with transaction.atomic():
        if Alert.objects.filter(pk=alert.pk, told_at=None).update(told_at=now, text=need.text):
            _prepare(alert, False, _recipients(), now)


def _clear(alert: Alert, now: datetime) -> None:
    if alert.told_at is None:
        Alert.objects.filter(pk=alert.pk, told_at=None).delete()
    elif alert.clear_since is None:
        Alert.objects.filter(pk=alert.pk, clear_since=None).update(clear_since=now)
    elif now - alert.clear_since >= _well_for(alert, now):
        with transaction.atomic():
            if Alert.objects.filter(pk=alert.pk, ended_at=None).update(ended_at=now):
                told = AlertMessage.objects.filter(alert=alert, over=False).select_related("user")
                _prepare(alert, True, [one.user for one in told if one.user is None or may_be_told(one.user)], now)


def _well_for(alert: Alert, now: datetime) -> timedelta:
    same = Alert.objects.filter(robot=alert.robot_id, kind=alert.kind, subject=alert.subject)
    return WELL_AGAIN if same.filter(ended_at__gte=now - LATELY).exists() else WELL


def _prepare(alert: Alert, over: bool, users: Iterable[Any], now: datetime) -> None:
    AlertMessage.objects.bulk_create(AlertMessage(alert=alert, over=over, user=user, next_at=now) for user in users)


def _recipients() -> list[Any]:
    """Return the staff who are told by mail, and None if there is a webhook."""
    silent = AlertChoice.objects.filter(by_mail=False).values("user")
    staff = get_user_model().objects.filter(is_active=True, is_staff=True).exclude(pk__in=silent)
    reachable = staff.filter(pk__in=EmailAddress.objects.filter(verified=True, primary=True).values("user"))
    hooks: list[Any] = [None] if settings.ALERTS["WEBHOOK"] else []
    return hooks + [user for user in reachable if may_be_told(user)]
