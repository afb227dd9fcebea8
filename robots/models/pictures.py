"""Rows of stored pictures, findings of commands, and programs."""

import secrets

from django.conf import settings
from django.db import models
from django.utils.translation import gettext_lazy

from robots.models.robot import Command, Grant, Robot


def frame_name() -> str:
    """Return the random part of a frame's name, so that names cannot be guessed or reused."""
    return secrets.token_hex(6)


class Frame(models.Model):
    """A stored picture: where the robot was, the verdict of the stability check, and the file."""

    robot = models.ForeignKey(Robot, models.CASCADE, related_name="frames")
    grant = models.ForeignKey(Grant, models.SET_NULL, null=True, blank=True, related_name="frames")
    command = models.ForeignKey(Command, models.SET_NULL, null=True, blank=True, related_name="frames")
    taken_at = models.DateTimeField()
    file = models.CharField(max_length=160)
    width = models.PositiveSmallIntegerField(gettext_lazy("width (px)"), default=0)
    height = models.PositiveSmallIntegerField(gettext_lazy("height (px)"), default=0)
    pose = models.JSONField(default=list)
    joints = models.JSONField(default=list)
    values = models.JSONField(default=dict, db_default={})  # of the channels that the spec declares, by name
    calibration = models.JSONField(default=dict)
    stable = models.BooleanField(default=False)
    verdict = models.CharField(max_length=60, blank=True)
    difference = models.FloatField(null=True, blank=True)
    tries = models.PositiveSmallIntegerField(default=0)
    kept = models.BooleanField(default=False, help_text=gettext_lazy("Chosen for a log entry: never cleaned away."))

    class Meta:
        ordering = ("-id",)
        verbose_name = gettext_lazy("picture")

    def __str__(self) -> str:
        return self.file

    def readings(self) -> tuple[tuple[str, float, str], ...]:
        """Return name, value and unit of the channels at that moment."""
        return self.robot.readings({"values": self.values}) if self.values else ()

    @property
    def url(self) -> str:
        """Return the address of the picture."""
        return f"{settings.MEDIA_URL}{self.file}"


class Finding(models.Model):
    """A finding of a long command: words, values, the robot's place, perhaps a picture."""

    command = models.ForeignKey(Command, models.CASCADE, related_name="findings")
    number = models.PositiveSmallIntegerField()  # counted from 1
    at = models.DateTimeField()
    text = models.CharField(max_length=200)
    values = models.JSONField(default=dict)  # of channels, by name
    pose = models.JSONField(default=list)
    frame = models.ForeignKey(Frame, models.SET_NULL, null=True, blank=True, related_name="findings")

    class Meta:
        ordering = ("command", "number")
        constraints = [models.UniqueConstraint(fields=["command", "number"], name="one_row_a_finding")]

    def __str__(self) -> str:
        return self.text

    def readings(self) -> tuple[tuple[str, float, str], ...]:
        """Return name, value and unit of what was measured."""
        return self.command.robot.readings({"values": self.values}) if self.values else ()


class Program(models.Model):
    """A list of steps in the robot's own language, checked and run as a whole."""

    robot = models.ForeignKey(Robot, models.CASCADE, related_name="programs")
    author = models.ForeignKey(
        settings.AUTH_USER_MODEL, models.CASCADE, null=True, blank=True, related_name="programs",
        help_text=gettext_lazy("Empty for one that came with the robot."),
    )  # fmt: skip
    kind = models.CharField(
        max_length=40, blank=True, default="",
        help_text=gettext_lazy("The command that runs it, of a robot with several languages; empty: its first."),
    )  # fmt: skip
    name = models.CharField(max_length=60)
    text = models.TextField(max_length=6000)
    shared = models.BooleanField(default=False, help_text=gettext_lazy("Its author would like others to see it."))
    approved = models.BooleanField(default=False, help_text=gettext_lazy("Shown in the gallery."))
    approved_by = models.ForeignKey(
        settings.AUTH_USER_MODEL, models.SET_NULL, verbose_name=gettext_lazy("decided by"), null=True, blank=True,
        related_name="+", editable=False,
    )  # fmt: skip
    changed_at = models.DateTimeField()

    class Meta:
        ordering = ("name",)
        constraints = [models.UniqueConstraint(fields=["robot", "author", "name"], name="a_name_once_an_author")]

    def __str__(self) -> str:
        return self.name
