"""The addresses in the settings: of this site, and of database, Redis and mail server.

Each is read once for all libraries that connect. Where TLS is asked for, certificates are checked.
"""

import os
import re
from collections.abc import Callable, Sequence
from typing import Any
from urllib.parse import parse_qsl, urlsplit

from django.core.exceptions import ImproperlyConfigured

ADDRESS = re.compile(r"https?://([A-Za-z0-9.-]+|\[[0-9A-Fa-f:.]+\])(:[0-9]{1,5})?")
OPTIONS = ("ssl_ca_certs", "ssl_ca_path", "ssl_certfile", "ssl_keyfile", "ssl_password")  # redis-py's names
CHECKS = {"ssl_cert_reqs": "required", "ssl_check_hostname": "true"}
UNCHECKED = ("allow", "prefer", "require")


def site_address(setting: str, origins: Sequence[str], hosts: Sequence[str], public: bool, port: int) -> str:
    """Return the address that mails link to; no request decides it. Raises ImproperlyConfigured.

    `setting` is that of FARHAND_URL; without one it is the first origin without a placeholder, or the first host, with
    the port unless the portal is public.
    """
    named = next((one for one in origins if "*" not in one), "")
    host = next(iter(hosts), "localhost").removeprefix(".")
    address = (setting or named or (f"https://{host}" if public else f"http://{host}:{port}")).rstrip("/")
    if not ADDRESS.fullmatch(address):
        raise ImproperlyConfigured(f"FARHAND_URL must be like https://robots.example.org, without a path: {address!r}")
    if public and not address.startswith("https://"):
        raise ImproperlyConfigured(f"FARHAND_URL of a public portal must begin with https://, not {address!r}")
    return address


def read_url(name: str, read: Callable[[], Any]) -> Any:
    """Return what `read` makes of the URL in that variable.

    Raises:
        ImproperlyConfigured: it cannot be read. The refused text is not shown: it could be a part of the password.
    """
    try:
        return read()
    except ValueError:
        raise ImproperlyConfigured(
            f"{name} cannot be read. Write / ? # @ : of its password as %2F %3F %23 %40 %3A, and check its port."
        ) from None


def redis_tls(url: str) -> dict[str, Any]:
    """Return how Celery connects to this Redis by TLS; empty without TLS. redis-py reads the same from the address.

    Raises:
        ImproperlyConfigured: the two would differ, or the certificate would not be checked.
    """
    scheme, there, _ = url.partition("://")
    if not there or scheme not in ("redis", "rediss", "unix"):
        raise ImproperlyConfigured("REDIS_URL has to begin with redis://, rediss:// (by TLS) or unix://.")
    if scheme == "unix":
        return {}
    asked = dict(parse_qsl(urlsplit(url).query, keep_blank_values=True))
    if asked.keys() - ({*OPTIONS, *CHECKS} if scheme == "rediss" else set()):  # its text may be half a password
        raise ImproperlyConfigured(
            f"REDIS_URL has an option that is not known here. After rediss:// there may be {', '.join(OPTIONS)}, after "
            "redis:// none; the number of the database stands in the path, and a ? in a password is written as %3F."
        )
    for name, wanted in CHECKS.items():
        if asked.get(name, wanted).lower() != wanted:
            raise ImproperlyConfigured(
                f"REDIS_URL has another {name} than {wanted}: the certificate behind rediss:// is always checked. "
                "For one of your own authority set ssl_ca_certs to the file of that authority."
            )
    if scheme == "redis":
        return {}
    return {"ssl_cert_reqs": "required", "ssl_check_hostname": True} | {k: asked[k] for k in OPTIONS if k in asked}


def check_database(options: dict[str, Any]) -> None:
    """Raise ImproperlyConfigured if libpq would use TLS without a check of the certificate."""
    mode = options.get("sslmode") or os.environ.get("PGSSLMODE", "")
    if mode in UNCHECKED:
        raise ImproperlyConfigured(
            f"sslmode={mode} (DATABASE_URL or PGSSLMODE) does not check the certificate of the database. Set "
            "sslmode=verify-full, and sslrootcert to system or to the file of your own authority; or set "
            "sslmode=disable, where the line to the database needs no TLS."
        )
