"""Alerts, and the messages by which staff are told of them: an outbox, so that a restart loses and repeats none."""

import uuid
from typing import Any

from django.conf import settings
from django.db import models
from django.db.models import Q
from django.utils.translation import gettext, gettext_lazy


class Kind(models.TextChoices):
    """What a robot needs staff for."""

    INCIDENT = "incident", gettext_lazy("Incident")
    NOT_READY = "not_ready", gettext_lazy("Not ready")
    STOPPED = "stopped", gettext_lazy("Stopped")
    SUSPENDED = "suspended", gettext_lazy("Jobs wait for staff")
    PROGRAMS = "programs", gettext_lazy("Programs wait for a review")


class Alert(models.Model):
    """One time that a robot needs staff: first seen, told to staff, and over. One that was never told is deleted."""

    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="alerts")
    kind = models.CharField(max_length=10, choices=Kind)
    subject = models.CharField(max_length=40, blank=True, help_text=gettext_lazy("The code of an incident."))
    text = models.CharField(max_length=300)
    seen_at = models.DateTimeField()
    told_at = models.DateTimeField(null=True, blank=True)
    clear_since = models.DateTimeField(
        null=True, blank=True, help_text=gettext_lazy("Since when the robot has been well again.")
    )
    ended_at = models.DateTimeField(null=True, blank=True)

    class Meta:
        ordering = ("-id",)
        constraints = [
            models.UniqueConstraint(
                fields=["robot", "kind", "subject"], condition=Q(ended_at=None), name="one_open_alert_of_a_kind"
            )
        ]

    def __str__(self) -> str:
        return f"{self.robot}: {self.get_kind_display()}"


class MessageState(models.TextChoices):
    """How far a message is."""

    WAITING = "waiting", gettext_lazy("Waiting")
    SENDING = "sending", gettext_lazy("Being sent")
    SENT = "sent", gettext_lazy("Sent")
    FAILED = "failed", gettext_lazy("Not sent")
    UNKNOWN = "unknown", gettext_lazy("Not known")


UNSENT = (MessageState.WAITING, MessageState.SENDING)


class AlertMessage(models.Model):
    """One message to one member of staff by mail, or to the webhook (no user)."""

    alert = models.ForeignKey(Alert, models.CASCADE, related_name="messages")
    over = models.BooleanField(help_text=gettext_lazy("It says that the robot needs nobody any more."))
    user = models.ForeignKey(settings.AUTH_USER_MODEL, models.CASCADE, null=True, blank=True, related_name="+")
    delivery = models.UUIDField(default=uuid.uuid4, editable=False)
    state = models.CharField(max_length=8, choices=MessageState, default=MessageState.WAITING)
    tries = models.PositiveSmallIntegerField(default=0)
    next_at = models.DateTimeField(
        help_text=gettext_lazy("When it is tried again, or taken for lost while it is being sent.")
    )
    sent_at = models.DateTimeField(null=True, blank=True)
    error = models.CharField(max_length=200, blank=True)

    class Meta:
        ordering = ("-id",)
        constraints = [
            models.UniqueConstraint(fields=["alert", "over", "user"], name="one_alert_mail_a_person"),
            models.UniqueConstraint(fields=["alert", "over"], condition=Q(user=None), name="one_alert_webhook_message"),
        ]
        indexes = [models.Index(fields=["next_at"], condition=Q(state__in=sorted(UNSENT)), name="alert_messages_due")]

    def __str__(self) -> str:
        if self.user is None:
            return gettext("over, to the webhook") if self.over else gettext("begun, to the webhook")
        words = gettext("over, to {user}") if self.over else gettext("begun, to {user}")
        return words.format(user=self.user)


class AlertChoice(models.Model):
    """Whether a member of staff wants alerts by mail; without a row they do."""

    user = models.OneToOneField(settings.AUTH_USER_MODEL, models.CASCADE, related_name="+")
    by_mail = models.BooleanField(default=True)

    def __str__(self) -> str:
        words = gettext("{user}: by mail") if self.by_mail else gettext("{user}: no mail")
        return words.format(user=self.user)


def may_be_told(user: Any) -> bool:
    """Return whether alerts are for this person."""
    return bool(user.is_active and user.is_staff and user.has_perm("robots.change_robot"))
