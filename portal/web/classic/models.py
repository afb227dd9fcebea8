"""The table of the console without scripts."""

from django.conf import settings
from django.db import models


class ClassicToken(models.Model):
    """The rotating token of the console without scripts: it allows at most one motion."""

    token = models.CharField(max_length=44, unique=True)
    user = models.ForeignKey(settings.AUTH_USER_MODEL, models.CASCADE, related_name="+")
    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="+")
    made_at = models.DateTimeField()
    spent_at = models.DateTimeField(null=True, blank=True)
    still = models.BigIntegerField(default=0, help_text="The picture that its page shows.")

    def __str__(self) -> str:
        return f"token of {self.user}"
