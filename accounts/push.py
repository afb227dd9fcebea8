"""Which browsers are told of a person's turn: stored by that person alone, few, and forgotten in time.

A browser's subscription is forgotten when the person signs out there, has a new password or is deactivated, when its
push service says that it is over, and after `MOST_FAILURES` failures in a row.
"""

from datetime import datetime
from typing import Any

from django.contrib.auth.signals import user_logged_out
from django.db.models import F, QuerySet
from django.dispatch import receiver
from django.utils.translation import gettext

from accounts.models import PushSubscription

MOST = 10  # browsers of a person; the oldest goes
MOST_FAILURES = 10
LONGEST, LONGEST_BROWSER = 1000, 60  # characters of an endpoint and of a browser's name
SESSION = "push"  # in a session: the number of the subscription of that browser


class PushRefused(Exception):
    """The browser cannot be told; the message says why."""


def subscriptions_of(user: Any) -> QuerySet[PushSubscription]:
    """Return the browsers that are told of a person's turn, the newest first."""
    return PushSubscription.objects.filter(user=user.pk).order_by("-pk")


def subscribe(user: Any, endpoint: str, keys: tuple[str, str], browser: str, now: datetime) -> PushSubscription:
    """Store that a browser is told of a person's turn from now on; `keys`: its public key and its secret.

    A browser is told of one person's turns only, who asked last. Whoever has only read an endpoint does not have its
    keys, and gets nothing of another person. Raises PushRefused.
    """
    p256dh, auth = keys
    if not user.is_authenticated or user.guest:
        raise PushRefused(gettext("Sign in first."))
    given = {"user": user, "p256dh": p256dh, "auth": auth, "browser": browser[:LONGEST_BROWSER]}
    found, made = PushSubscription.objects.get_or_create(endpoint=endpoint, defaults={**given, "created_at": now})
    if not made and found.user_id != user.pk and (found.p256dh, found.auth) != keys:
        raise PushRefused(gettext("This browser could not be added. Switch its notifications off and on again."))
    if not made:
        PushSubscription.objects.filter(pk=found.pk).update(**given, failures=0)
    kept = list(subscriptions_of(user).values_list("pk", flat=True)[:MOST])
    subscriptions_of(user).exclude(pk__in=kept).delete()
    return found


def unsubscribe(user: Any, number: int) -> bool:
    """Tell that browser of the person no more. Return whether it was told."""
    return bool(PushSubscription.objects.filter(user=user.pk or 0, pk=number).delete()[0])


def unsubscribe_all(user: Any) -> None:
    """Tell no browser of the person any more."""
    PushSubscription.objects.filter(user=user.pk).delete()


def note_push(subscription: PushSubscription, taken: bool | None, now: datetime) -> None:
    """Note whether a push service took a message; `None`: it said that the subscription is over."""
    mine = PushSubscription.objects.filter(pk=subscription.pk)
    if taken:
        mine.update(last_success_at=now, failures=0)
    elif taken is None:
        mine.delete()
    else:
        mine.update(failures=F("failures") + 1)
        mine.filter(failures__gte=MOST_FAILURES).delete()


@receiver(user_logged_out)
def unsubscribe_signed_out(request: Any = None, user: Any = None, **_: Any) -> None:
    """Forget the browser in which a person signs out."""
    session = getattr(request, "session", None)
    if session is not None and user is not None and isinstance(number := session.get(SESSION), int):
        unsubscribe(user, number)
