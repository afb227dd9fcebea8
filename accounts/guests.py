"""Guests: people without an account, who practise on a simulator. Each has a row of its own, which is removed later."""

import secrets
from datetime import datetime, timedelta

from accounts.models import User

LASTS = timedelta(days=1)
MOST = 1000  # that are removed at a time


def new_guest(now: datetime) -> User:
    """Make the row of somebody who practises without an account: no password opens it, and no mail reaches it."""
    name = f"guest-{secrets.token_hex(4)}"
    guest = User(username=name, email=f"{name}@guest.invalid", guest=True, date_joined=now)
    guest.set_unusable_password()
    guest.save()
    return guest


def remove_guests(now: datetime) -> int:
    """Remove the rows of guests that are a day old. Return how many."""
    old = User.objects.filter(guest=True, date_joined__lt=now - LASTS).order_by("pk")[:MOST]
    return sum(guest.delete()[0] > 0 for guest in old)
