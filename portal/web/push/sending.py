"""Tells the browsers of people that a robot is offered to them: each once, all at the same time, in limited time.

Nothing is tried again: an offer lasts half a minute. A push service that is slow or away holds up nothing but this
task, and that for a few seconds.
"""

import logging
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from datetime import datetime

from django.conf import settings
from django.utils import translation
from django.utils.translation import gettext

from accounts.models import PushSubscription
from accounts.push import note_push, subscriptions_of
from portal.web import outgoing
from portal.web.push import messages
from queueing.models import Ticket
from queueing.services import take_due_pushes

log = logging.getLogger(__name__)
AT_ONCE = 32  # threads; more browsers wait until some are done
LONGEST_S = 2 * messages.LIMITS.all  # the slowest look-up of a name is not waited for


def tell_offers(now: datetime) -> int:
    """Tell of the offers that were made since the last call. Return how many browsers were told."""
    if not settings.PUSH["ON"]:
        return 0
    due = [(one, message) for ticket in take_due_pushes(now) for one, message in _written(ticket)]
    if not due:
        return 0
    pool = ThreadPoolExecutor(AT_ONCE, "push")
    begun = {pool.submit(messages.send, one, message, now): one for one, message in due}
    done, late = wait(begun, LONGEST_S)
    pool.shutdown(wait=False, cancel_futures=True)
    told = 0
    for future in done:
        taken: bool | None = False
        try:
            taken = future.result()
        except outgoing.NotReached as error:
            log.info("a push service was not reachable: %s", error)
        note_push(begun[future], taken, now)
        told += taken is True
    for future in late:
        note_push(begun[future], False, now)
    return told


def _written(ticket: Ticket) -> Iterator[tuple[PushSubscription, messages.Message]]:
    assert ticket.robot is not None
    assert ticket.offer_until is not None
    with translation.override(ticket.user.language or settings.LANGUAGE_CODE):
        message = messages.Message(
            title=gettext("It is your turn on {name}").format(name=ticket.robot.full_name),
            body=gettext("Take control before {time}, when the offer ends."),
            url=ticket.robot.get_absolute_url(),
            language=translation.get_language() or settings.LANGUAGE_CODE,
            tag=f"turn-{ticket.robot.slug}",
            topic=f"robot-{ticket.robot.pk}",
            until=ticket.offer_until,
        )
    if ticket.user.is_active:
        for one in subscriptions_of(ticket.user):
            yield one, message
