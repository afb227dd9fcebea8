"""The key that origin and edges of the movie of the day share."""

from django.conf import settings
from django.utils.crypto import salted_hmac

from portal.broadcast import packets

LOOPBACK = "lo"


def broadcast_key(interface: str) -> bytes:
    """Return the key: that of the settings, or, on the machine itself, one of this installation.

    Raises ValueError where a key has to be given.
    """
    told = settings.BROADCAST_KEY
    if not told and interface == LOOPBACK:
        told = salted_hmac("portal.broadcast", "key", algorithm="sha256").hexdigest()
    if not told:
        raise ValueError(f"On {interface}, origin and edges need the same FARHAND_BROADCAST_KEY.")
    return packets.key_of(told)
