"""The times in which robots were out of service, as the status page said it."""

from django.db import models
from django.db.models import Q
from django.utils.translation import gettext


class Downtime(models.Model):
    """A time in which nobody could drive a robot, in the words of the status page. It names nobody."""

    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="downtimes")
    label = models.CharField(max_length=80)
    reason = models.CharField(max_length=300, blank=True)  # while it lasts: no page tells it afterwards
    began_at = models.DateTimeField()
    changed_at = models.DateTimeField()
    ended_at = models.DateTimeField(null=True, blank=True)

    class Meta:
        ordering = ("-began_at", "-id")
        constraints = [
            models.UniqueConstraint(fields=["robot"], condition=Q(ended_at=None), name="one_open_downtime_a_robot")
        ]
        indexes = [models.Index(fields=["robot", "began_at"], name="downtimes_of_a_robot")]

    def __str__(self) -> str:
        return gettext("{robot} since {time}").format(robot=self.robot, time=f"{self.began_at:%Y-%m-%d %H:%M} UTC")
