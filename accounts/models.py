"""People, and the test that clears them for a robot."""

from django.conf import settings
from django.contrib.auth.models import AbstractUser
from django.core.validators import RegexValidator
from django.db import models
from django.db.models import Q
from django.utils.translation import gettext, gettext_lazy

from accounts.handles import HandleKey


class TurnLength(models.IntegerChoices):
    """How many times as long as usual a person's turns are."""

    USUAL = 1, gettext_lazy("as long as usual")
    TWICE = 2, gettext_lazy("twice as long")
    THREE_TIMES = 3, gettext_lazy("three times as long")
    FOUR_TIMES = 4, gettext_lazy("four times as long")


class User(AbstractUser):
    """A person; the username is the handle shown to others."""

    username = models.CharField(
        gettext_lazy("handle"), max_length=30, unique=True,
        validators=[
            RegexValidator(
                r"^[\w.-]{2,30}\Z", gettext_lazy("Use 2 to 30 letters, digits, dots, dashes or underscores.")
            )
        ],
        help_text=gettext_lazy("Shown to others when you drive. 2 to 30 letters, digits, . - _"),
        error_messages={"unique": gettext_lazy("That handle is taken.")},
    )  # fmt: skip
    handle_key = HandleKey(max_length=255, unique=True, null=True, editable=False)
    email = models.EmailField(gettext_lazy("email address"), unique=True)
    guest = models.BooleanField(
        default=False, db_default=False, editable=False,
        help_text=gettext_lazy("Somebody without an account, who may only practise on a simulator."),
    )  # fmt: skip

    language = models.CharField(
        max_length=10, blank=True, default="", db_default="", editable=False
    )  # of mails; empty: English
    # to who watches, while and after this person drives; staff read it always
    name_shown = models.BooleanField(default=True, db_default=True, editable=False)

    turn_factor = models.PositiveSmallIntegerField(
        gettext_lazy("turns"), choices=TurnLength, default=TurnLength.USUAL, db_default=TurnLength.USUAL,
        help_text=gettext_lazy(
            "For a person who needs more time, of turns on all robots, also to take control and before a turn ends "
            "because nothing is done. In the queue it costs as much as a usual turn. Only the person and staff "
            "can read this."
        ),
    )  # fmt: skip

    class Meta(AbstractUser.Meta):
        constraints = [
            models.CheckConstraint(condition=Q(turn_factor__in=TurnLength.values), name="a_known_length_of_turns")
        ]
        verbose_name = gettext_lazy("person")  # type: ignore[assignment] # lazy, as Django reads it
        verbose_name_plural = gettext_lazy("people")  # type: ignore[assignment]

    def __str__(self) -> str:
        return self.username


class Question(models.Model):
    """One question of a robot's question bank."""

    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="questions")
    text = models.CharField(max_length=300)
    topic = models.CharField(
        max_length=60, blank=True, help_text=gettext_lazy("Shown to a person who answers it wrongly.")
    )
    section = models.CharField(
        max_length=80, blank=True, help_text=gettext_lazy("Heading of the orientation's section that answers it.")
    )
    paragraph = models.PositiveSmallIntegerField(
        default=1, help_text=gettext_lazy("Of that section; list items count.")
    )
    explanation = models.CharField(
        max_length=400, blank=True,
        help_text=gettext_lazy(
            "For staff: why the right answer is right. It is not shown to people who take the test."
        ),
    )  # fmt: skip
    active = models.BooleanField(default=True)

    class Meta:
        verbose_name = gettext_lazy("clearance question")

    def __str__(self) -> str:
        return self.text


class Choice(models.Model):
    """One possible answer."""

    question = models.ForeignKey(Question, models.CASCADE, related_name="choices")
    text = models.CharField(max_length=200)
    correct = models.BooleanField(default=False)

    def __str__(self) -> str:
        return self.text


class OrientationRead(models.Model):
    """A person has read a robot's orientation."""

    user = models.ForeignKey(settings.AUTH_USER_MODEL, models.CASCADE, related_name="+")
    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="+")
    at = models.DateTimeField()

    class Meta:
        constraints = [models.UniqueConstraint(fields=["user", "robot"], name="orientation_once")]

    def __str__(self) -> str:
        return gettext("{user} read {robot}").format(user=self.user_id, robot=self.robot_id)


class Attempt(models.Model):
    """One attempt at the clearance test; its questions are drawn when it starts."""

    user = models.ForeignKey(settings.AUTH_USER_MODEL, models.CASCADE, related_name="attempts")
    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="+")
    drawn = models.JSONField(help_text=gettext_lazy("Question ids in the order shown, each with its choice ids."))
    started_at = models.DateTimeField()
    finished_at = models.DateTimeField(null=True, blank=True)
    answers = models.JSONField(default=dict, blank=True)
    score = models.PositiveSmallIntegerField(null=True, blank=True)
    passed = models.BooleanField(null=True, blank=True)

    class Meta:
        constraints = [
            models.UniqueConstraint(
                fields=["user", "robot"], condition=Q(finished_at=None), name="one_open_attempt_a_person"
            )
        ]
        verbose_name, verbose_name_plural = gettext_lazy("attempt at a test"), gettext_lazy("attempts at tests")

    def __str__(self) -> str:
        return gettext("attempt {number}").format(number=self.pk)


class Clearance(models.Model):
    """The permission of a person to drive a robot, up to a level."""

    user = models.ForeignKey(settings.AUTH_USER_MODEL, models.CASCADE, related_name="clearances")
    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="+")
    level = models.PositiveSmallIntegerField(default=1)
    granted_at = models.DateTimeField()
    revoked_at = models.DateTimeField(null=True, blank=True)
    note = models.CharField(
        max_length=200, blank=True, help_text=gettext_lazy("Why it was withdrawn; the person can read this.")
    )
    lifted_at = models.DateTimeField(null=True, blank=True)  # since when the test may be taken again
    decided_by = models.ForeignKey(
        settings.AUTH_USER_MODEL, models.SET_NULL, null=True, blank=True, related_name="+", editable=False
    )

    class Meta:
        constraints = [models.UniqueConstraint(fields=["user", "robot", "level"], name="clearance_once")]

    def __str__(self) -> str:
        return gettext("{user} on {robot}").format(user=self.user, robot=self.robot)


class PushSubscription(models.Model):
    """A browser that is told, by the push service of its vendor, that it is a person's turn."""

    user = models.ForeignKey(settings.AUTH_USER_MODEL, models.CASCADE, related_name="push_subscriptions")
    endpoint = models.CharField(max_length=1000, unique=True)  # who knows it can have messages delivered
    p256dh = models.CharField(max_length=88)  # the browser's public key, in base64url
    auth = models.CharField(max_length=24)  # a secret that the browser has told us only
    browser = models.CharField(max_length=60, blank=True)
    created_at = models.DateTimeField()
    last_success_at = models.DateTimeField(null=True, blank=True)
    failures = models.PositiveSmallIntegerField(default=0)  # since the last success

    class Meta:
        verbose_name, verbose_name_plural = gettext_lazy("push subscription"), gettext_lazy("push subscriptions")

    def __str__(self) -> str:
        return gettext("a browser of {user}").format(user=self.user)


class TurnMail(models.Model):
    """Whether a person is told of their turn by e-mail, too, and how many of these mails they got within an hour."""

    user = models.OneToOneField(settings.AUTH_USER_MODEL, models.CASCADE, related_name="turn_mail")
    on = models.BooleanField(default=False)
    since = models.DateTimeField(null=True, blank=True)  # when the first mail of the present hour was sent
    sent = models.PositiveSmallIntegerField(default=0)  # since then

    def __str__(self) -> str:
        words = gettext("{user}: by mail") if self.on else gettext("{user}: no mail")
        return words.format(user=self.user)
