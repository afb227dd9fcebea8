"""Sends the messages of alerts that are due, each by one process; what fails is tried again, later and later.

A mail that a server may have taken is not sent again. A webhook may get a message again after an answer that did not
come in time; each time it has the same delivery number.
"""

import logging
import smtplib
from datetime import datetime, timedelta

from allauth.account.models import EmailAddress
from django.conf import settings
from django.core.mail import EmailMessage, get_connection
from django.db.models import F
from django.utils import translation
from django.utils.translation import gettext

from portal.web.alerts import webhook
from portal.web.alerts.models import UNSENT, AlertMessage, MessageState
from robots.dates import date_words
from robots.sentences import translate

log = logging.getLogger(__name__)
FIRST_PAUSE = timedelta(minutes=1)  # it doubles
TRIES = 8  # over two hours
TAKEN_FOR_LOST = timedelta(minutes=5)  # a message that a process began to send and did not finish
AT_ONCE = 20  # so that a mail server that is slow keeps nobody for long
REFUSALS = (smtplib.SMTPResponseException, smtplib.SMTPRecipientsRefused)


class NotSent(Exception):
    """It was not sent, and may be tried again."""


class MaybeSent(Exception):
    """Nobody knows whether it was sent."""


def send_due(now: datetime) -> int:
    """Send the messages that are due, those to one receiver in order. Return how many were sent."""
    _find_lost(now)
    due = AlertMessage.objects.filter(state=MessageState.WAITING, next_at__lte=now).order_by("id")
    return sum(_send(one, now) for one in due.select_related("alert__robot", "user")[:AT_ONCE] if not _waits(one))


def _waits(message: AlertMessage) -> bool:
    """Return whether its receiver was not told yet that there is an alert."""
    if not message.over:
        return False
    begun = AlertMessage.objects.filter(alert=message.alert_id, over=False, user=message.user_id)
    return begun.filter(state__in=UNSENT).exists()


def _find_lost(now: datetime) -> None:
    """Look after messages whose process ended while it sent them."""
    lost = AlertMessage.objects.filter(state=MessageState.SENDING, next_at__lte=now)
    lost.filter(user=None).update(state=MessageState.WAITING)
    lost.exclude(user=None).update(
        state=MessageState.UNKNOWN, error="The process ended while it sent this mail, which is not sent again."
    )


def _send(message: AlertMessage, now: datetime) -> bool:
    mine = AlertMessage.objects.filter(pk=message.pk, state=MessageState.WAITING)
    if not mine.update(state=MessageState.SENDING, tries=F("tries") + 1, next_at=now + TAKEN_FOR_LOST):
        return False  # another process sends it
    begun = AlertMessage.objects.filter(pk=message.pk, state=MessageState.SENDING)
    try:
        _mail(message) if message.user is not None else webhook.post(message, now)
    except (NotSent, webhook.WebhookError) as error:
        tries = message.tries + 1
        state = MessageState.WAITING if tries < TRIES else MessageState.FAILED
        begun.update(state=state, next_at=now + FIRST_PAUSE * 2 ** (tries - 1), error=str(error)[:200])
        log.warning("an alert could not be sent (attempt %d of %d): %s", tries, TRIES, error)
        return False
    except MaybeSent as error:
        begun.update(state=MessageState.UNKNOWN, error=str(error)[:200])
        log.error("nobody knows whether a mail of an alert was sent: %s", error)
        return False
    begun.update(state=MessageState.SENT, sent_at=now, error="")
    return True


def _written(message: AlertMessage) -> tuple[str, str]:
    """Return the subject and the text of a mail, in the language that is active."""
    alert, site, name = message.alert, settings.SITE_ADDRESS, message.alert.robot.full_name
    subject = gettext("{name} no longer needs staff") if message.over else gettext("{name} needs staff")
    lines = [
        f"{translate(alert.get_kind_display())}: {translate(alert.text)}",
        gettext("Since {time} UTC.").format(time=_at(alert.seen_at)),
        gettext("Over since {time} UTC.").format(time=_at(alert.clear_since or alert.ended_at)) if message.over else "",
        f"{site}/admin/robots/robot/{alert.robot_id}/change/",
        gettext("You can switch these mails off: {address}").format(address=f"{site}/me/"),
    ]
    return subject.format(name=name), "\n\n".join(line for line in lines if line) + "\n"


def _at(time: datetime | None) -> str:
    return date_words(time, "minute") if time is not None else ""


def _mail(message: AlertMessage) -> None:
    address = EmailAddress.objects.filter(user=message.user_id, verified=True, primary=True).first()
    if address is None:
        raise NotSent("The person has no confirmed address now.")
    with translation.override(getattr(message.user, "language", "") or settings.LANGUAGE_CODE):
        subject, text = _written(message)
    connection = get_connection()
    try:
        connection.open()
    except (OSError, smtplib.SMTPException) as error:
        raise NotSent(f"The mail server cannot be reached: {error}") from error
    mail = EmailMessage(subject, text, to=[address.email], connection=connection)
    mail.extra_headers["Message-ID"] = f"<{message.delivery}@farhand.invalid>"
    try:
        mail.send()
    except REFUSALS as error:
        raise NotSent(f"The mail server refused it: {error}") from error
    except (OSError, smtplib.SMTPException) as error:
        raise MaybeSent(f"The mail server did not answer: {error}") from error
    finally:
        connection.close()
