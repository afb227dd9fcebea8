"""Rows of recordings and of the movies made from them."""

import secrets
from datetime import datetime, timedelta

from django.conf import settings
from django.db import models
from django.db.models import Q
from django.utils.translation import gettext, gettext_lazy


class Records(models.TextChoices):
    """The parts of a robot's work that are recorded."""

    OFF = "off", gettext_lazy("Nothing")
    WORK = "work", gettext_lazy("Turns and jobs")


class RecordingState(models.TextChoices):
    """The states of a recording; all but the first are final."""

    RUNNING = "running", gettext_lazy("Being recorded")
    READY = "ready", gettext_lazy("Ready")
    CUT = "cut", gettext_lazy("Cut short")
    REMOVED = "removed", gettext_lazy("Removed")


SHOWN = (RecordingState.READY, RecordingState.CUT)


class OfTheDay(models.TextChoices):
    """The decision of staff whether a recording's movie is the movie of the day."""

    BY_RULE = "", gettext_lazy("By the rule")
    PINNED = "pinned", gettext_lazy("Until staff say otherwise")
    NEVER = "never", gettext_lazy("Never")


def new_key() -> str:
    """Return the random part of an address."""
    return secrets.token_urlsafe(18)


class Recording(models.Model):
    """A robot's work under one grant: a file with pictures, states, commands and events on one clock."""

    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="recordings")
    grant = models.OneToOneField("robots.Grant", models.CASCADE, related_name="recording")
    key = models.CharField(max_length=32, unique=True, default=new_key, editable=False)
    state = models.CharField(max_length=8, choices=RecordingState, default=RecordingState.RUNNING)
    reason = models.CharField(
        max_length=200, blank=True, help_text=gettext_lazy("Why it was cut short or removed, or has gaps.")
    )
    began_at = models.DateTimeField()
    ended_at = models.DateTimeField(null=True, blank=True)
    file = models.CharField(max_length=160)
    size = models.BigIntegerField(gettext_lazy("size (bytes)"), default=0)
    dropped = models.PositiveIntegerField(
        default=0, help_text=gettext_lazy("Messages left out because the disk was too slow.")
    )
    version = models.PositiveIntegerField(default=1, help_text=gettext_lazy("Grows when pictures are taken out."))
    taken_out = models.JSONField(
        default=list, blank=True, help_text=gettext_lazy("Spans of pictures to take out at the end.")
    )
    host = models.CharField(max_length=80, blank=True, help_text=gettext_lazy("Where its recorder runs."))
    filmed = models.PositiveIntegerField(
        default=0,
        db_default=0,
        help_text=gettext_lazy("The version of which a movie was to be made by itself; 0: none."),
    )
    track = models.JSONField(
        default=dict, db_default={}, blank=True, help_text=gettext_lazy("Its path: driven, planned (m).")
    )
    of_the_day = models.CharField(
        gettext_lazy("movie of the day"), max_length=6, choices=OfTheDay, default="", db_default="", blank=True
    )

    class Meta:
        ordering = ("-id",)
        indexes = [models.Index(fields=["robot", "began_at"], name="recordings_by_time")]

    def __str__(self) -> str:
        return gettext("recording {number}").format(number=self.pk)

    def get_absolute_url(self) -> str:
        """Return the address of its page."""
        return f"/recordings/{self.key}/"

    @property
    def replayable(self) -> bool:
        """Return whether there is a file to replay."""
        return self.state in SHOWN

    @property
    def kept_until(self) -> datetime:
        """Return when it is removed."""
        return self.began_at + timedelta(days=keep_days(self.robot))


def keep_days(robot: "models.Model") -> int:
    """Return for how many days recordings of a robot are kept, at least one."""
    days: int | None = getattr(robot, "recordings_keep_days", None)
    return max(1, settings.RECORDING["KEEP_DAYS"] if days is None else days)


class Movie(models.Model):
    """A movie of a recording, or a time-lapse of a robot's day: asked for or due by itself, kept for some days."""

    class Kind(models.TextChoices):
        """The containers, each with the codec that browsers play in it."""

        MP4 = "mp4", gettext_lazy("MP4 (H.264)")
        WEBM = "webm", gettext_lazy("WebM (VP9)")

    class State(models.TextChoices):
        """From the request to the file."""

        WAITING = "waiting", gettext_lazy("Waiting to be made")
        MAKING = "making", gettext_lazy("Being made")
        READY = "ready", gettext_lazy("Ready")
        FAILED = "failed", gettext_lazy("Failed")

    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="movies")
    recording = models.ForeignKey(Recording, models.CASCADE, null=True, blank=True, related_name="movies")
    day = models.DateField(null=True, blank=True, help_text=gettext_lazy("Of a time-lapse (UTC)."))
    # recordings by number, and stored pictures by file: all that the time-lapse shows, and everybody could see then
    sources = models.JSONField(default=list, blank=True, help_text=gettext_lazy("The recordings of a time-lapse."))
    kind = models.CharField(max_length=4, choices=Kind)
    version = models.PositiveIntegerField(default=1, help_text=gettext_lazy("Of its recording."))
    state = models.CharField(max_length=8, choices=State, default=State.WAITING)
    reason = models.CharField(max_length=200, blank=True)
    asked_at = models.DateTimeField()
    begun_at = models.DateTimeField(null=True, blank=True)
    ready_at = models.DateTimeField(null=True, blank=True)
    size = models.BigIntegerField(gettext_lazy("size (bytes)"), default=0)
    progress = models.PositiveSmallIntegerField(
        gettext_lazy("progress (%)"), default=0, help_text=gettext_lazy("While it is made.")
    )
    unasked = models.BooleanField(
        default=False, db_default=False, help_text=gettext_lazy("Made by itself, after those asked for.")
    )
    tries = models.PositiveSmallIntegerField(
        default=0, db_default=0, help_text=gettext_lazy("How often it could not be made.")
    )

    class Meta:
        ordering = ("-id",)
        constraints = [
            models.UniqueConstraint(
                fields=["recording", "kind", "version"], condition=Q(recording__isnull=False), name="a_movie_once"
            ),
            models.UniqueConstraint(
                fields=["robot", "day", "kind"], condition=Q(day__isnull=False), name="a_time_lapse_once"
            ),
        ]

    def __str__(self) -> str:
        return f"{self.kind} {self.pk}"

    @property
    def open(self) -> bool:
        """Return whether it is still to be made."""
        return self.state in (self.State.WAITING, self.State.MAKING)

    @property
    def ahead(self) -> int:
        """Return how many movies are made before it."""
        waiting, earlier = Movie.objects.filter(state=self.State.WAITING), Q(pk__lt=self.pk or 0)
        before = waiting.filter(Q(unasked=False) | earlier if self.unasked else Q(unasked=False) & earlier).count()
        return before + Movie.objects.filter(state=self.State.MAKING).exclude(pk=self.pk).count()
