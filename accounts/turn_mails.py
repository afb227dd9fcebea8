"""Who is told of their turn by e-mail: whoever chose it, at a confirmed address alone, and only so often in an hour."""

from datetime import datetime, timedelta
from typing import Any

from allauth.account.models import EmailAddress
from django.db.models import F, Q, QuerySet
from django.utils.translation import gettext

from accounts.models import TurnMail

MOST, HOUR = 6, timedelta(hours=1)  # mails in an hour, which begins with the first of them


class MailRefused(Exception):
    """The person cannot be told by e-mail; the message says why."""


def told_by_mail() -> QuerySet[TurnMail]:
    """Return the choices of the people who are told, each with a confirmed address."""
    confirmed = Q(user__emailaddress__verified=True, user__emailaddress__primary=True)
    return TurnMail.objects.filter(confirmed, on=True, user__guest=False)


def mail_choice(user: Any) -> bool | None:
    """Return whether the person is told by e-mail; None: they cannot be, for they have no confirmed address."""
    found = list(_confirmed(user).values_list("user__turn_mail__on", flat=True))
    return bool(found[0]) if found else None


def choose_mail(user: Any, on: bool) -> None:
    """Tell the person by e-mail from now on, or no more. Raises MailRefused."""
    if on and mail_choice(user) is None:
        raise MailRefused(gettext("Confirm your e-mail address first."))
    if on or TurnMail.objects.filter(user=user.pk or 0).exists():
        TurnMail.objects.update_or_create(user_id=user.pk, defaults={"on": on})


def mail_address(user: Any) -> str:
    """Return the address at which the person is told; empty: they are not."""
    found = _confirmed(user).filter(user__turn_mail__on=True).first()
    return str(found.email) if found else ""


def _confirmed(user: Any) -> Any:  # allauth has no types
    return EmailAddress.objects.filter(user=user.pk or 0, user__guest=False, verified=True, primary=True)


def count_mail(user: Any, now: datetime) -> bool:
    """Count a mail to the person. Return False, and count none, if there were enough within an hour."""
    mine = TurnMail.objects.filter(user=user.pk)
    another_hour = Q(since=None) | Q(since__lte=now - HOUR) | Q(since__gt=now)  # or the clock was set back
    if mine.filter(another_hour).update(since=now, sent=1):
        return True
    return bool(mine.filter(sent__lt=MOST).update(sent=F("sent") + 1))


def uncount_mail(user: Any) -> None:
    """Count a mail no more that was not sent."""
    TurnMail.objects.filter(user=user.pk, sent__gt=0).update(sent=F("sent") - 1)
