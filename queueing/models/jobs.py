"""Jobs: requests that wait for their turn without a person present."""

import secrets

from django.conf import settings
from django.db import models
from django.db.models import Q
from django.utils.translation import gettext, gettext_lazy


class JobState(models.TextChoices):
    """The states of a job; the last four are final."""

    WAITING = "waiting", gettext_lazy("Waiting")
    RUNNING = "running", gettext_lazy("Running")
    DONE = "done", gettext_lazy("Done")
    FAILED = "failed", gettext_lazy("Failed")
    CANCELLED = "cancelled", gettext_lazy("Cancelled")
    UNKNOWN = "unknown", gettext_lazy("Unknown")


OPEN_JOB = (JobState.WAITING, JobState.RUNNING)


def new_key() -> str:
    """Return the random part of a job's address."""
    return secrets.token_urlsafe(18)


class Job(models.Model):
    """One command that a person or a guest asked for; each run has a grant.

    `start_tag` is empty while another request of the same account is ahead. `guest` is the hash of a guest's cookie,
    `shown_name` the name that the asker wants on the page, and `form` identifies one press of a button.
    """

    queue = models.ForeignKey("queueing.Queue", models.CASCADE, related_name="jobs")
    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="jobs")
    account = models.ForeignKey("queueing.Account", models.CASCADE, related_name="jobs")
    user = models.ForeignKey(settings.AUTH_USER_MODEL, models.CASCADE, null=True, blank=True, related_name="jobs")
    guest = models.CharField(max_length=64, blank=True)
    key = models.CharField(max_length=32, unique=True, default=new_key, editable=False)
    form = models.CharField(max_length=64, blank=True, default="", db_default="", editable=False)
    kind = models.CharField(max_length=30)
    args = models.JSONField(default=dict, blank=True)
    start_tag = models.FloatField(gettext_lazy("start tag (s or jobs)"), null=True, blank=True)
    state = models.CharField(max_length=10, choices=JobState, default=JobState.WAITING)
    reason = models.CharField(max_length=300, blank=True)
    code = models.CharField(
        max_length=40, blank=True, default="", db_default="", editable=False,
        help_text=gettext_lazy("The robot's own word for why it ended before it began."),
    )  # fmt: skip
    shown_name = models.CharField(max_length=40, blank=True)
    mail = models.BooleanField(default=False, help_text=gettext_lazy("Its asker wants a mail at its end."))
    asked_at = models.DateTimeField()
    # when the picture that its asker saw was taken, as the page reported; the command gets the same
    seen_picture_at = models.DateTimeField(null=True, blank=True)
    cancel_asked_at = models.DateTimeField(null=True, blank=True)
    ended_at = models.DateTimeField(null=True, blank=True)
    told_at = models.DateTimeField(null=True, blank=True, help_text=gettext_lazy("Its asker has seen how it ended."))
    faults = models.PositiveSmallIntegerField(
        default=0, help_text=gettext_lazy("How often the robot failed during it.")
    )
    charged = models.FloatField(gettext_lazy("charged (s or jobs)"), null=True, blank=True)
    surveyed = models.BooleanField(default=False, help_text=gettext_lazy("Its asker has answered the survey."))

    class Meta:
        ordering = ("-id",)
        constraints = [
            models.UniqueConstraint(
                fields=["account"], condition=Q(state__in=OPEN_JOB, start_tag__isnull=False),
                name="one_tagged_job_an_account",
            ),
            models.UniqueConstraint(fields=["account", "form"], condition=~Q(form=""), name="one_job_a_form"),
            models.UniqueConstraint(
                fields=["queue", "guest"], condition=Q(state__in=OPEN_JOB) & ~Q(guest=""), name="one_open_job_a_guest"
            ),
        ]  # fmt: skip
        indexes = [
            models.Index(fields=["robot", "state", "start_tag", "id"], name="jobs_in_tag_order"),
            models.Index(fields=["robot", "asked_at"], name="jobs_by_time"),  # statistics of a day
        ]

    def __str__(self) -> str:
        words = gettext("job {number}: {kind} ({state})")
        return words.format(number=self.pk, kind=self.kind, state=self.get_state_display())

    def get_absolute_url(self) -> str:
        """Return the address of the job's page."""
        return f"/jobs/{self.key}/"

    def last_run(self) -> "JobRun | None":
        """Return the job's newest run, with its grant."""
        return self.runs.select_related("grant").order_by("-id").first()


class JobRun(models.Model):
    """One run of a job: its grant, under which its command stands."""

    job = models.ForeignKey(Job, models.CASCADE, related_name="runs")
    grant = models.OneToOneField("robots.Grant", models.CASCADE, related_name="job_run")

    class Meta:
        ordering = ("id",)

    def __str__(self) -> str:
        return gettext("run of job {number}").format(number=self.job_id)
