"""Posts an alert to the webhook of the settings: signed JSON."""

import hashlib
import hmac
import json
from datetime import datetime
from typing import Any

from django.conf import settings

from portal.web import outgoing
from portal.web.alerts.models import AlertMessage

LIMITS = outgoing.Limits(each=5.0, all=15.0)
SECRET_LENGTH = 16  # characters at least


class WebhookError(Exception):
    """The webhook did not take the message; the text says why."""


def check(url: str, secret: str) -> None:
    """Raises ValueError with what is wrong with a webhook's address or the secret."""
    try:
        outgoing.https_parts(url)
    except ValueError as error:
        raise ValueError(
            "FARHAND_ALERT_WEBHOOK must be like https://chat.example.org/hook, without user and password."
        ) from error
    if len(secret) < SECRET_LENGTH:
        raise ValueError(
            f"FARHAND_ALERT_SECRET must have {SECRET_LENGTH} characters or more: messages are signed by it."
        )


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
    body = json.dumps(content(message)).encode()
    headers = {
        "Content-Type": "application/json", "User-Agent": "Farhand", "Farhand-Delivery": str(message.delivery),
        "Farhand-Signature": signature(body, int(now.timestamp()), rules["SECRET"]),
    }  # fmt: skip
    try:
        check(rules["WEBHOOK"], rules["SECRET"])
        status = outgoing.post(rules["WEBHOOK"], body, headers, LIMITS, rules["PRIVATE"])
    except outgoing.NotPublic as error:
        raise WebhookError(f"The webhook cannot be reached: {error}; FARHAND_ALERT_PRIVATE allows it.") from error
    except (outgoing.NotReached, ValueError) as error:
        raise WebhookError(f"The webhook cannot be reached: {error}") from error
    if 300 <= status < 400:
        raise WebhookError("The webhook answered with a redirect, which is not followed.")
    if not 200 <= status < 300:
        raise WebhookError(f"The webhook answered with status {status}.")
