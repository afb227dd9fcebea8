"""Posts an alert to the webhook of the settings: signed JSON over HTTPS, without redirects, within a limited time.

The name is looked up once and that address is connected to, so it cannot change after it was judged.
"""

import contextlib
import hashlib
import hmac
import http.client
import ipaddress
import json
import socket
import ssl
import threading
from datetime import datetime
from typing import Any
from urllib.parse import SplitResult, urlsplit

from django.conf import settings

from portal.web.alerts.models import AlertMessage
from robots.kit.addresses import AddressError, check_host

EACH_S, ALL_S = 5.0, 15.0  # for each step of the connection, and for the whole request
SECRET_LENGTH = 16  # characters at least


class WebhookError(Exception):
    """The webhook did not take the message; the text says why."""


def checked(url: str, secret: str) -> SplitResult:
    """Return the parts of a webhook's address. Raises ValueError with what is wrong with it or the secret."""
    parts = urlsplit(url)
    if parts.scheme != "https" or not parts.hostname or parts.username or parts.password or parts.fragment:
        raise ValueError("FARHAND_ALERT_WEBHOOK must be like https://chat.example.org/hook, without user and password.")
    _ = parts.port  # ValueError if it is none
    if len(secret) < SECRET_LENGTH:
        raise ValueError(
            f"FARHAND_ALERT_SECRET must have {SECRET_LENGTH} characters or more: messages are signed by it."
        )
    return parts


def content(message: AlertMessage) -> dict[str, Any]:
    """Return what the webhook is told."""
    alert = message.alert
    ended = (alert.clear_since or alert.ended_at) if message.over else None
    return {
        "delivery": str(message.delivery), "event": "over" if message.over else "needs_staff", "alert": alert.pk,
        "robot": alert.robot.slug, "name": alert.robot.full_name, "kind": alert.kind, "text": alert.text,
        "since": alert.seen_at.isoformat(), "until": ended.isoformat() if ended else None,
        "url": f"{settings.SITE_ADDRESS}/admin/robots/robot/{alert.robot_id}/change/",
    }  # fmt: skip


def signature(body: bytes, at_s: int, secret: str) -> str:
    """Return the value of the header `Farhand-Signature` for a body sent at that time (s since 1970)."""
    digest = hmac.new(secret.encode(), f"{at_s}.".encode() + body, hashlib.sha256).hexdigest()
    return f"t={at_s},v1={digest}"


def post(message: AlertMessage, now: datetime) -> None:
    """Post a message; an answer of 2xx means that it was taken. Raises WebhookError."""
    rules = settings.ALERTS
    try:
        parts = checked(rules["WEBHOOK"], rules["SECRET"])
        place = _place(parts.hostname or "", parts.port or 443, rules["PRIVATE"])
        body = json.dumps(content(message)).encode()
        headers = {
            "Content-Type": "application/json", "User-Agent": "Farhand", "Farhand-Delivery": str(message.delivery),
            "Farhand-Signature": signature(body, int(now.timestamp()), rules["SECRET"]), "Connection": "close",
        }  # fmt: skip
        status = _request(parts, place, body, headers)
    except (OSError, http.client.HTTPException, ValueError) as error:
        raise WebhookError(f"The webhook cannot be reached: {error or type(error).__name__}") from error
    if 300 <= status < 400:
        raise WebhookError("The webhook answered with a redirect, which is not followed.")
    if not 200 <= status < 300:
        raise WebhookError(f"The webhook answered with status {status}.")


def _place(host: str, port: int, private: bool) -> str:
    """Return the numeric address to connect to. Raises OSError, AddressError (a ValueError)."""
    check_host(host)
    found = [str(place[0]) for *_, place in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)]
    for one in found:
        check_host(one)
        address = ipaddress.ip_address(one.partition("%")[0])
        if not private and not (getattr(address, "ipv4_mapped", None) or address).is_global:
            raise AddressError(f"{one} is a private address; FARHAND_ALERT_PRIVATE allows it.")
    if not found:
        raise OSError("its name has no address")
    return found[0]


def tls() -> ssl.SSLContext:
    """Return how certificates are checked: as everywhere, by the system's authorities or SSL_CERT_FILE."""
    return ssl.create_default_context()


class _Pinned(http.client.HTTPSConnection):
    """A connection to a host at an address that was judged before."""

    def __init__(self, host: str, port: int, place: str) -> None:
        self._tls, self._place = tls(), place
        super().__init__(host, port, timeout=EACH_S, context=self._tls)

    def connect(self) -> None:
        line = socket.create_connection((self._place, self.port), timeout=EACH_S)
        self.sock = line  # known before the handshake, so that it can be ended
        self.sock = self._tls.wrap_socket(line, server_hostname=self.host)

    def cut(self) -> None:
        """End whatever goes on."""
        if self.sock is not None:
            with contextlib.suppress(OSError):
                self.sock.shutdown(socket.SHUT_RDWR)


def _request(parts: SplitResult, place: str, body: bytes, headers: dict[str, str]) -> int:
    connection = _Pinned(parts.hostname or "", parts.port or 443, place)
    limit = threading.Timer(ALL_S, connection.cut)  # a peer that sends a byte now and then is within each step's limit
    limit.daemon = True
    limit.start()
    try:
        target = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
        connection.request("POST", target, body, headers)
        return connection.getresponse().status
    finally:
        limit.cancel()
        connection.close()
