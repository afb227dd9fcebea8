"""Messages to push services (RFC 8030): signed by the installation (RFC 8292), encrypted for one browser (RFC 8291)."""

import base64
import binascii
import json
from dataclasses import dataclass
from datetime import datetime
from email.utils import parseaddr
from functools import cache
from typing import Any
from urllib.parse import urlsplit

from django.conf import settings
from django.templatetags.static import static
from django.utils.translation import gettext

from accounts.models import PushSubscription
from accounts.push import LONGEST, PushRefused
from portal.web import outgoing
from robots.kit.addresses import check_host

LIMITS = outgoing.Limits(each=3.0, all=5.0)
VALID_S = 12 * 3600  # of a signature; push services allow a day
POINT, SECRET = 65, 16  # bytes of a browser's key and of its secret
OVER = (404, 410)
HTTPS = 443


@dataclass(frozen=True)
class Message:
    """What a browser shows, and for how long it is of use (s); a later one of the same topic replaces it."""

    title: str
    body: str  # `{time}` is replaced by the end of the offer, in the time zone of the browser
    url: str
    language: str
    tag: str  # of the notification: an open page shows its own with the same
    topic: str  # of the message: at most 32 letters of base64url
    until: datetime

    def data(self) -> bytes:
        """Return what the service worker reads (frontend/src/push/worker.ts)."""
        return json.dumps(
            {"title": self.title, "body": self.body, "url": self.url, "lang": self.language, "tag": self.tag,
             "icon": static("portal/icon-turn.svg"), "until_ms": int(self.until.timestamp() * 1000)}
        ).encode()  # fmt: skip


def checked_keys(p256dh: str, auth: str) -> tuple[str, str]:
    """Return the key and the secret of a browser in the form in which they are stored. Raises PushRefused."""
    from cryptography.hazmat.primitives.asymmetric import ec  # noqa: PLC0415 - only who sends or is told needs it

    try:
        point, secret = _bytes_of(p256dh, POINT), _bytes_of(auth, SECRET)
        ec.EllipticCurvePublicKey.from_encoded_point(ec.SECP256R1(), point)
    except ValueError as error:
        raise PushRefused(gettext("The browser's keys for notifications cannot be used.")) from error
    return _text_of(point), _text_of(secret)


def checked_endpoint(endpoint: str) -> str:
    """Return the address of a browser at its push service; its name is looked up later. Raises PushRefused."""
    wrong = PushRefused(gettext("The address of the browser's push service cannot be used."))
    if not 0 < len(endpoint) <= LONGEST or not endpoint.isascii() or not endpoint.isprintable() or " " in endpoint:
        raise wrong
    try:
        parts = outgoing.https_parts(endpoint)
        host = parts.hostname or ""
        check_host(host)
        if not settings.PUSH["PRIVATE"] and ((parts.port or HTTPS) != HTTPS or _is_private(host)):
            raise wrong
    except ValueError as error:  # AddressError too
        raise wrong from error
    return endpoint


def _is_private(host: str) -> bool:
    try:
        return not outgoing.is_public(host)
    except ValueError:  # a name
        return "." not in host.rstrip(".")


def send(subscription: PushSubscription, message: Message, now: datetime) -> bool | None:
    """Send a message. Return whether the push service took it; None if it says that the subscription is over."""
    left_s = max(0, int((message.until - now).total_seconds()))
    headers = {
        "Content-Encoding": "aes128gcm", "Content-Type": "application/octet-stream", "TTL": str(left_s),
        "Urgency": "high", "Topic": message.topic, **_signed(subscription.endpoint, now),
    }  # fmt: skip
    body = _encrypted(message.data(), subscription)
    status = outgoing.post(subscription.endpoint, body, headers, LIMITS, settings.PUSH["PRIVATE"])
    return None if status in OVER else 200 <= status < 300


def public_key() -> str:
    """Return the installation's public key, which pages give to the browser; empty without Web Push."""
    if not settings.PUSH["ON"]:
        return ""
    from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat  # noqa: PLC0415 - as above

    return _text_of(_vapid().public_key.public_bytes(Encoding.X962, PublicFormat.UncompressedPoint))


@cache
def _vapid() -> Any:  # the library has no types
    from py_vapid import Vapid02  # noqa: PLC0415 - as above

    return Vapid02.from_raw(settings.PUSH["KEY"].encode())


def _signed(endpoint: str, now: datetime) -> dict[str, str]:
    parts = urlsplit(endpoint)
    _, contact = parseaddr(settings.DEFAULT_FROM_EMAIL)
    claims = {
        "aud": f"{parts.scheme}://{parts.netloc}", "exp": int(now.timestamp()) + VALID_S, "sub": f"mailto:{contact}"
    }  # fmt: skip
    headers: dict[str, str] = _vapid().sign(claims)
    return headers


def _encrypted(data: bytes, subscription: PushSubscription) -> bytes:
    import http_ece  # noqa: PLC0415 - as above
    from cryptography.hazmat.primitives.asymmetric import ec  # noqa: PLC0415

    key = ec.generate_private_key(ec.SECP256R1())
    point, secret = _bytes_of(subscription.p256dh, POINT), _bytes_of(subscription.auth, SECRET)
    body: bytes = http_ece.encrypt(data, private_key=key, dh=point, auth_secret=secret, version="aes128gcm")
    return body


def _bytes_of(text: str, length: int) -> bytes:
    """Return the bytes of a text in base64url. Raises ValueError if they are not so many."""
    if len(text) > 2 * length:
        raise ValueError("too long")
    try:
        found = base64.b64decode(text.rstrip("=") + "=" * (-len(text.rstrip("=")) % 4), altchars=b"-_", validate=True)
    except binascii.Error as error:
        raise ValueError("not base64url") from error
    if len(found) != length:
        raise ValueError("of another length")
    return found


def _text_of(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).decode().rstrip("=")
