"""The address of this portal."""

import re
from collections.abc import Sequence

from django.core.exceptions import ImproperlyConfigured

ADDRESS = re.compile(r"https?://([A-Za-z0-9.-]+|\[[0-9A-Fa-f:.]+\])(:[0-9]{1,5})?")


def site_address(asked: str, origins: Sequence[str], hosts: Sequence[str], public: bool, port: int) -> str:
    """Return the address that mails link to; no request decides it. Raises ImproperlyConfigured.

    `asked` is that of FARHAND_URL; without one it is the first origin without a placeholder, or the first host, with
    the port unless the portal is public.
    """
    named = next((one for one in origins if "*" not in one), "")
    host = next(iter(hosts), "localhost").removeprefix(".")
    address = (asked or named or (f"https://{host}" if public else f"http://{host}:{port}")).rstrip("/")
    if not ADDRESS.fullmatch(address):
        raise ImproperlyConfigured(f"FARHAND_URL must be like https://robots.example.org, without a path: {address!r}")
    if public and not address.startswith("https://"):
        raise ImproperlyConfigured(f"FARHAND_URL of a public portal must begin with https://, not {address!r}")
    return address
