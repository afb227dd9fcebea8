"""The figures of one day (UTC): of a robot, or of the whole portal. They name nobody."""

from django.db import models
from django.db.models import Q


class DailyFigures(models.Model):
    """One row a day and robot, and one a day for the whole portal, which has no robot. None: not known."""

    day = models.DateField()
    robot = models.ForeignKey("robots.Robot", models.CASCADE, null=True, blank=True, related_name="daily")
    hits = models.BigIntegerField(null=True, blank=True, help_text="Pages that were shown.")
    addresses = models.BigIntegerField(null=True, blank=True, help_text="Different network addresses of these.")
    addresses_whole = models.BooleanField(default=True, help_text="No: there were more addresses than were counted.")
    turns = models.PositiveIntegerField(null=True, blank=True)
    commands = models.PositiveIntegerField(null=True, blank=True, help_text="Of turns and jobs.")
    entries = models.PositiveIntegerField(null=True, blank=True, help_text="Of the operator's log.")
    finds = models.PositiveIntegerField(null=True, blank=True, help_text="Reported that day, and confirmed.")
    watching = models.PositiveIntegerField(null=True, blank=True, help_text="Most at once.")
    online_s = models.FloatField(null=True, blank=True, help_text="Of the portal: all robots together.")
    sent_bytes = models.BigIntegerField(null=True, blank=True, help_text="Live, to people who watched.")

    class Meta:
        ordering = ("day", "id")
        constraints = [
            models.UniqueConstraint(fields=["robot", "day"], name="one_row_a_robot_and_day"),
            models.UniqueConstraint(fields=["day"], condition=Q(robot=None), name="one_row_of_the_portal_a_day"),
        ]

    def __str__(self) -> str:
        return f"{self.day} of {self.robot or 'the portal'}"
