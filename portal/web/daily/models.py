"""The figures of one day (UTC): of a robot, or of the whole portal. They name nobody."""

from django.db import models
from django.db.models import Q
from django.utils.translation import gettext, gettext_lazy


class DailyFigures(models.Model):
    """One row a day and robot, and one a day for the whole portal, which has no robot. None: not known."""

    day = models.DateField()
    robot = models.ForeignKey("robots.Robot", models.CASCADE, null=True, blank=True, related_name="daily")
    hits = models.BigIntegerField(null=True, blank=True, help_text=gettext_lazy("Pages that were shown."))
    addresses = models.BigIntegerField(
        null=True, blank=True, help_text=gettext_lazy("Different network addresses of these.")
    )
    addresses_whole = models.BooleanField(
        default=True, help_text=gettext_lazy("No: there were more addresses than were counted.")
    )
    turns = models.PositiveIntegerField(null=True, blank=True)
    commands = models.PositiveIntegerField(null=True, blank=True, help_text=gettext_lazy("Of turns and jobs."))
    entries = models.PositiveIntegerField(null=True, blank=True, help_text=gettext_lazy("Of the operator's log."))
    finds = models.PositiveIntegerField(
        null=True, blank=True, help_text=gettext_lazy("Reported that day, and confirmed.")
    )
    watching = models.PositiveIntegerField(null=True, blank=True, help_text=gettext_lazy("Most at once."))
    online_s = models.FloatField(null=True, blank=True, help_text=gettext_lazy("Of the portal: all robots together."))
    sent_bytes = models.BigIntegerField(null=True, blank=True, help_text=gettext_lazy("Live, to people who watched."))

    wait_median_s = models.FloatField(
        null=True, blank=True, help_text=gettext_lazy("Of the turns that began: from joining the queue to control.")
    )
    wait_longest_s = models.FloatField(null=True, blank=True, help_text=gettext_lazy("Of the same."))
    success = models.FloatField(
        null=True, blank=True,
        help_text=gettext_lazy("The share of commands that were carried out, of those that nobody ended before."),
    )  # fmt: skip
    faults = models.PositiveIntegerField(null=True, blank=True, help_text=gettext_lazy("Incidents, without outages."))
    outages = models.PositiveIntegerField(
        null=True, blank=True, help_text=gettext_lazy("Times in which a robot's worker did not answer.")
    )

    class Meta:
        ordering = ("day", "id")
        constraints = [
            models.UniqueConstraint(fields=["robot", "day"], name="one_row_a_robot_and_day"),
            models.UniqueConstraint(fields=["day"], condition=Q(robot=None), name="one_row_of_the_portal_a_day"),
        ]

    def __str__(self) -> str:
        if self.robot is None:
            return gettext("{day} of the portal").format(day=self.day)
        return gettext("{day} of {robot}").format(day=self.day, robot=self.robot)
