"""Rows of the use of robots: grants, leases, commands, incidents, and counters of use."""

from datetime import datetime

from django.conf import settings
from django.db import models
from django.db.models import Q

from robots.kit.contract.ranges import readable
from robots.models.catalogue import Robot
from robots.states import COMMAND_FINAL, CommandState, GrantEnd, GrantKind, Lane


class Grant(models.Model):
    """Permission to move one robot, from now on. A robot has at most one open grant."""

    robot = models.ForeignKey(Robot, models.CASCADE, related_name="grants")
    kind = models.CharField(max_length=10, choices=GrantKind)
    holder = models.ForeignKey(settings.AUTH_USER_MODEL, models.SET_NULL, null=True, blank=True, related_name="+")
    epoch = models.BigIntegerField(default=0)
    opened_at = models.DateTimeField()
    until = models.DateTimeField(null=True, blank=True)
    ended_at = models.DateTimeField(null=True, blank=True)
    end_code = models.CharField(max_length=12, choices=GrantEnd, blank=True)
    end_reason = models.CharField(max_length=120, blank=True)

    class Meta:
        constraints = [
            models.UniqueConstraint(fields=["robot"], condition=Q(ended_at=None), name="one_open_grant_a_robot")
        ]

    def __str__(self) -> str:
        return f"{self.get_kind_display()} on {self.robot_id}"


class Lease(models.Model):
    """The process that owns a robot; the epoch only ever grows."""

    robot = models.OneToOneField(Robot, models.CASCADE, related_name="lease")
    epoch = models.BigIntegerField(default=0)
    host = models.CharField(max_length=80, blank=True)
    pid = models.IntegerField(default=0)
    started = models.CharField(max_length=40, blank=True, help_text="Start time of that process.")
    expires_at = models.DateTimeField(null=True, blank=True)
    state = models.JSONField(default=dict, blank=True)
    state_at = models.DateTimeField(null=True, blank=True)

    def __str__(self) -> str:
        return f"epoch {self.epoch}"


class Usage(models.Model):
    """Five minutes of a robot: how long it was online, how many watched at once, and what was sent to them."""

    robot = models.ForeignKey(Robot, models.CASCADE, related_name="usage")
    at = models.DateTimeField(help_text="The beginning of the five minutes.")
    online_s = models.FloatField(default=0.0)
    watching = models.PositiveIntegerField(default=0, help_text="Most at once; the sum over all web processes.")
    sent_bytes = models.BigIntegerField(default=0)

    class Meta:
        constraints = [models.UniqueConstraint(fields=["robot", "at"], name="one_usage_a_time")]

    def __str__(self) -> str:
        return f"{self.at:%Y-%m-%d %H:%M}"


class Command(models.Model):
    """One request to a robot. Services create rows; only the owner changes them."""

    robot = models.ForeignKey(Robot, models.CASCADE, related_name="commands")
    grant = models.ForeignKey(Grant, models.CASCADE, related_name="commands")
    client_seq = models.BigIntegerField()
    issued_by = models.ForeignKey(settings.AUTH_USER_MODEL, models.SET_NULL, null=True, related_name="+")
    kind = models.CharField(max_length=30)
    lane = models.CharField(max_length=8, choices=Lane, default=Lane.MOTION)
    args = models.JSONField(default=dict)
    epoch = models.BigIntegerField()
    state = models.CharField(max_length=12, choices=CommandState, default=CommandState.QUEUED)
    reason = models.CharField(max_length=300, blank=True)
    created_at = models.DateTimeField()
    deadline = models.DateTimeField()
    limit_s = models.FloatField(default=15.0)
    accepted_at = models.DateTimeField(null=True, blank=True)
    sent_at = models.DateTimeField(null=True, blank=True)
    acknowledged_at = models.DateTimeField(null=True, blank=True)
    ended_at = models.DateTimeField(null=True, blank=True)
    result = models.JSONField(default=dict, blank=True)
    progress = models.JSONField(default=dict, blank=True)  # text, share (0 to 1 or None), at_ms
    # when the picture was taken that its sender saw, as the page said, and the newest that the robot's worker had taken
    seen_picture_at = models.DateTimeField(null=True, blank=True)
    newest_picture_at = models.DateTimeField(null=True, blank=True)
    clamping = models.JSONField(default=dict, db_default={}, blank=True)  # name: asked, sent, where they differ

    class Meta:
        ordering = ("-id",)
        constraints = [models.UniqueConstraint(fields=["grant", "client_seq"], name="one_row_a_client_seq")]
        indexes = [
            models.Index(
                fields=["robot", "id"], condition=~Q(state__in=sorted(COMMAND_FINAL)), name="unfinished_commands"
            ),
            models.Index(fields=["robot", "kind", "id"], condition=Q(lane="config"), name="config_commands"),
            models.Index(fields=["robot", "ended_at"], name="commands_by_end"),  # statistics of a day
        ]

    def __str__(self) -> str:
        return f"{self.kind} #{self.pk}"

    @property
    def reached_at(self) -> datetime:
        """Return when the present stage was reached."""
        return self.ended_at or self.acknowledged_at or self.sent_at or self.accepted_at or self.created_at

    @property
    def picture_lag_s(self) -> float | None:
        """Return by how much the picture that its sender saw was older than the robot's newest (s); None: not known."""
        if self.seen_picture_at is None or self.newest_picture_at is None:
            return None
        return (self.newest_picture_at - self.seen_picture_at).total_seconds()

    @property
    def clamped_words(self) -> str:
        """Return what was sent instead of what was asked, as "speed 0.3 instead of 0.5"; empty if nothing differs."""
        told = ((name, readable(asked), readable(sent)) for name, (asked, sent) in self.clamping.items())
        return ", ".join(f"{name} {sent} instead of {asked}" for name, asked, sent in told)

    @property
    def final(self) -> bool:
        """Return whether the command has ended."""
        return self.state in COMMAND_FINAL


class Incident(models.Model):
    """A fault of a robot, kept for staff."""

    robot = models.ForeignKey(Robot, models.CASCADE, related_name="incidents")
    command = models.ForeignKey(Command, models.SET_NULL, null=True, blank=True)
    at = models.DateTimeField()
    code = models.CharField(max_length=40)
    text = models.CharField(max_length=300)
    remedy = models.CharField(max_length=300, blank=True, help_text="What the portal did about it.")
    closed_at = models.DateTimeField(null=True, blank=True)

    class Meta:
        ordering = ("-at",)

    def __str__(self) -> str:
        return self.text
