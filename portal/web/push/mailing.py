"""Tells people by e-mail that a robot is offered to them: once for an offer, and only while it stands.

A mail that the server surely has not taken is tried again as long as the offer stands; one that it may have taken is
not. A mail server that is slow or away holds up nothing but this task.
"""

import logging
import smtplib
from typing import Any

from django.conf import settings
from django.core.mail import EmailMessage, get_connection
from django.utils import translation
from django.utils.translation import gettext

from accounts.services import cleared
from accounts.turn_mails import count_mail, mail_address, uncount_mail
from queueing.models import Ticket
from queueing.services import due_mails, give_mail_back, take_due_mail
from robots.dates import date_words
from robots.kit.clock import Clock

log = logging.getLogger(__name__)
TIMEOUT_S = 10  # of each answer of the mail server: an offer lasts half a minute
PERMANENT = 500  # codes from here on: the same again would be refused again
REFUSALS = (smtplib.SMTPResponseException, smtplib.SMTPRecipientsRefused)


def mail_offers(clock: Clock) -> int:
    """Tell of the open offers. Return how many mails were sent."""
    sent = 0
    for ticket in due_mails(clock.now()):
        connection = get_connection(timeout=TIMEOUT_S)
        try:
            connection.open()
            sent += _tell(ticket, connection, clock)
        except smtplib.SMTPAuthenticationError as error:
            log.error("the mail server refuses the portal's password: %s", error.smtp_code)
            take_due_mail(ticket, clock.now())  # asked again and again, it may lock the portal's account
            break
        except (OSError, smtplib.SMTPException) as error:
            log.warning("the mail server cannot be reached, so mails of turns wait: %s", error)
            break  # all others, too, would wait for it
        finally:
            connection.close()
    return sent


def _tell(ticket: Ticket, connection: Any, clock: Clock) -> bool:
    assert ticket.robot is not None
    now = clock.now()  # the server may have let us wait
    address = mail_address(ticket.user) if cleared(ticket.user, ticket.robot) else ""
    if not take_due_mail(ticket, now) or not address or not count_mail(ticket.user, now):
        return False
    try:
        EmailMessage(*_written(ticket), to=[address], connection=connection).send()
    except REFUSALS as error:
        codes = _codes(error)  # the rest names the address
        log.warning("the mail server refused a mail of a turn: %s", codes)
        uncount_mail(ticket.user)
        if max(codes, default=0) < PERMANENT:
            give_mail_back(ticket)
        return False
    except (OSError, smtplib.SMTPException) as error:
        log.warning("nobody knows whether a mail of a turn was sent: %s", error)
        return False
    return True


def _codes(error: smtplib.SMTPException) -> list[int]:
    """Return the answers of a mail server that refused a mail."""
    if isinstance(error, smtplib.SMTPRecipientsRefused):
        return [code for code, _ in error.recipients.values()]
    return [error.smtp_code] if isinstance(error, smtplib.SMTPResponseException) else []


def _written(ticket: Ticket) -> tuple[str, str]:
    """Return the subject and the text of a mail, in the person's language."""
    assert ticket.robot is not None
    assert ticket.offer_until is not None
    site = settings.SITE_ADDRESS
    with translation.override(ticket.user.language or settings.LANGUAGE_CODE):
        subject = gettext("It is your turn on {name}").format(name=ticket.robot.full_name)
        lines = (
            gettext("Take control before {time} UTC, when the offer ends:").format(
                time=date_words(ticket.offer_until, "second")
            ),
            f"{site}{ticket.robot.get_absolute_url()}",
            gettext("You can switch these mails off: {address}").format(address=f"{site}/me/"),
        )
    return subject, "\n\n".join(lines) + "\n"
