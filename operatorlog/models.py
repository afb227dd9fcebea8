"""The operator's log and the survey."""

from django.conf import settings
from django.db import models
from django.db.models import Q
from django.utils.translation import gettext, gettext_lazy, gettext_noop, pgettext

from queueing.models import Turn
from robots.people import handle_of, shown_name


class Visibility(models.TextChoices):
    """The people who see an entry."""

    PUBLISHED = "published", gettext_lazy("Published")
    FEATURED = "featured", gettext_lazy("Featured")
    HIDDEN = "hidden", gettext_lazy("Hidden")


class Entry(models.Model):
    """The text of an operator after a turn, with one picture of that turn; it outlives the author's account."""

    turn = models.OneToOneField(Turn, models.CASCADE, related_name="entry")
    author = models.ForeignKey(settings.AUTH_USER_MODEL, models.SET_NULL, null=True, related_name="entries")
    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="entries")
    text = models.TextField(max_length=2000)
    frame = models.ForeignKey("robots.Frame", models.SET_NULL, null=True, blank=True, related_name="entries")
    written_at = models.DateTimeField()
    edited_at = models.DateTimeField(null=True, blank=True)
    visibility = models.CharField(max_length=10, choices=Visibility, default=Visibility.PUBLISHED)
    hidden_reason = models.CharField(max_length=200, blank=True)
    # the moderator's own, after the reason
    hidden_words = models.CharField(max_length=300, blank=True, default="", db_default="")
    waits = models.BooleanField(default=True, db_default=True, editable=False)  # for a moderator's look
    # counts changes, decisions and appeals
    revision = models.PositiveIntegerField(default=0, db_default=0, editable=False)
    moderated_by = models.ForeignKey(
        settings.AUTH_USER_MODEL, models.SET_NULL, null=True, blank=True, related_name="+", editable=False
    )
    moderated_at = models.DateTimeField(null=True, blank=True, editable=False)

    class Meta:
        ordering = ("-written_at",)
        verbose_name, verbose_name_plural = gettext_lazy("log entry"), gettext_lazy("log entries")
        # read at each request for a stored picture
        indexes = [
            models.Index(fields=["turn"], condition=Q(visibility="hidden"), name="hidden_entries"),
            models.Index(fields=["id"], condition=Q(waits=True), name="waiting_entries"),
        ]

    def __str__(self) -> str:
        return f"{shown_name(self.author_name)}: {self.text[:60]}"

    @property
    def why_hidden(self) -> str:
        """Return the reason in the reader's language, and the moderator's own words."""
        return " ".join(filter(None, (self.hidden_reason and gettext(self.hidden_reason), self.hidden_words)))

    @property
    def author_name(self) -> str:
        """Return the author's handle, or that the account was deleted."""
        return handle_of(self.author)


class HidingReason(models.Model):
    """A reason to hide an entry, from which moderators choose. The author reads its text."""

    text = models.CharField(max_length=200, unique=True)
    position = models.PositiveSmallIntegerField(default=0)
    active = models.BooleanField(default=True)

    class Meta:
        ordering = ("position", "id")
        verbose_name, verbose_name_plural = gettext_lazy("reason to hide"), gettext_lazy("reasons to hide")

    def __str__(self) -> str:
        return self.text


class Decision(models.Model):
    """A moderator's decision about an entry: what they had read, and how the entry was before."""

    entry = models.ForeignKey(Entry, models.CASCADE, related_name="decisions")
    by = models.ForeignKey(settings.AUTH_USER_MODEL, models.SET_NULL, null=True, related_name="+")
    at = models.DateTimeField()
    visibility = models.CharField(max_length=10, choices=Visibility)
    revision = models.PositiveIntegerField()  # the entry's, after the decision
    text = models.TextField(max_length=2000)
    picture = models.CharField(max_length=200, blank=True)
    was_visibility = models.CharField(max_length=10, choices=Visibility)
    was_reason = models.CharField(max_length=200, blank=True)
    was_words = models.CharField(max_length=300, blank=True)
    was_waiting = models.BooleanField()
    was_moderated_by = models.ForeignKey(settings.AUTH_USER_MODEL, models.SET_NULL, null=True, related_name="+")
    was_moderated_at = models.DateTimeField(null=True)
    undone_at = models.DateTimeField(null=True)

    class Meta:
        ordering = ("id",)
        constraints = [models.UniqueConstraint(fields=["entry", "revision"], name="one_decision_a_revision")]

    def __str__(self) -> str:
        return f"{self.get_visibility_display()}: {self.entry}"


class Appeal(models.Model):
    """The author's request for another look at a hidden entry; it is open until a moderator decides."""

    entry = models.ForeignKey(Entry, models.CASCADE, related_name="appeals")
    words = models.CharField(max_length=500)
    at = models.DateTimeField()
    answer = models.ForeignKey(Decision, models.SET_NULL, null=True, related_name="appeals")

    class Meta:
        ordering = ("id",)
        constraints = [
            models.UniqueConstraint(fields=["entry"], condition=Q(answer=None), name="one_open_appeal_an_entry")
        ]

    def __str__(self) -> str:
        return self.words[:60]


class SurveyQuestion(models.Model):
    """One question of the survey after a turn, after a job, or after both."""

    class After(models.TextChoices):
        """The occasion after which it is asked."""

        TURN = "turn", gettext_lazy("A turn")
        JOB = "job", gettext_lazy("A job")
        BOTH = "both", gettext_lazy("A turn and a job")

    class Kind(models.TextChoices):
        """The kind of answer."""

        CHOICE = "choice", gettext_lazy("Choice")
        SCALE = "scale", gettext_lazy("Scale 1 to 5")
        TEXT = "text", gettext_lazy("Text")

    prompt = models.CharField(max_length=200)
    kind = models.CharField(max_length=6, choices=Kind, default=Kind.SCALE)
    options = models.TextField(blank=True, help_text=gettext_lazy("One choice a line."))
    low_label = models.CharField(max_length=40, blank=True)
    high_label = models.CharField(max_length=40, blank=True)
    position = models.PositiveSmallIntegerField(default=0)
    active = models.BooleanField(default=True)
    after = models.CharField(max_length=4, choices=After, default=After.BOTH)

    class Meta:
        ordering = ("position", "id")

    def __str__(self) -> str:
        return self.prompt

    def choices(self) -> list[str]:
        """Return the possible values; empty for text."""
        if self.kind == self.Kind.SCALE:
            return ["1", "2", "3", "4", "5"]
        return [line.strip() for line in self.options.splitlines() if line.strip()]


class SurveyResponse(models.Model):
    """One person's answers: after a turn, with which they are stored, or after a job, without a name.

    After a job only the robot and the day are stored, so that nobody knows whose answers they are.
    """

    turn = models.OneToOneField(Turn, models.CASCADE, null=True, blank=True, related_name="survey")
    robot = models.ForeignKey("robots.Robot", models.CASCADE, null=True, blank=True, related_name="surveys")
    at = models.DateTimeField()

    class Meta:
        verbose_name = verbose_name_plural = gettext_lazy("survey answers")
        constraints = [
            models.CheckConstraint(
                condition=Q(turn__isnull=False, robot=None) | Q(turn=None, robot__isnull=False),
                name="after_a_turn_or_a_job",
            )
        ]

    def __str__(self) -> str:
        if self.turn_id:
            return gettext("survey of turn {number}").format(number=self.turn_id)
        return gettext("survey of a job on {robot}").format(robot=self.robot_id)


class SurveyAnswer(models.Model):
    """One answer to a question: the value as text, without a name."""

    response = models.ForeignKey(SurveyResponse, models.CASCADE, related_name="answers")
    question = models.ForeignKey(SurveyQuestion, models.CASCADE, related_name="answers")
    value = models.TextField(max_length=1000)
    # the question's kind at that time, so that results do not change; empty if an old backup did not contain it
    kind = models.CharField(max_length=6, choices=SurveyQuestion.Kind, blank=True, default="", db_default="")

    class Meta:
        constraints = [models.UniqueConstraint(fields=["response", "question"], name="one_answer_a_question")]

    def __str__(self) -> str:
        return self.value[:60]


class Round(models.Model):
    """The time from one hiding of the pieces to the next: the present round of a robot has no end."""

    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="rounds")
    number = models.PositiveIntegerField()
    puzzle = models.CharField(
        max_length=300, blank=True, help_text=gettext_lazy("What people are asked to find out; everybody reads it.")
    )
    began_at = models.DateTimeField()
    ended_at = models.DateTimeField(null=True, blank=True, editable=False)
    begun_by = models.ForeignKey(
        settings.AUTH_USER_MODEL, models.SET_NULL, null=True, blank=True, related_name="+", editable=False
    )
    # the command that makes the bed of a simulated robot anew; none where staff hide the pieces by hand
    command = models.ForeignKey(
        "robots.Command", models.SET_NULL, null=True, blank=True, related_name="+", editable=False
    )

    class Meta:
        ordering = ("robot", "-number")
        permissions = [("renew_round", gettext_noop("Can end a round and hide the pieces again"))]
        constraints = [
            models.UniqueConstraint(fields=["robot", "number"], name="one_number_a_round"),
            models.UniqueConstraint(fields=["robot"], condition=Q(ended_at=None), name="one_present_round"),
        ]

    def __str__(self) -> str:
        return gettext("round {number} of {robot}").format(number=self.number, robot=self.robot)


class Piece(models.Model):
    """A piece of a round: its name and its place (m) are told to staff alone until somebody has found it."""

    round = models.ForeignKey(Round, models.CASCADE, related_name="pieces")
    name = models.CharField(max_length=80)
    x = models.FloatField(gettext_lazy("x (m)"), null=True, blank=True)
    y = models.FloatField(gettext_lazy("y (m)"), null=True, blank=True)

    class Meta:
        ordering = ("name",)
        constraints = [models.UniqueConstraint(fields=["round", "name"], name="one_name_a_piece")]

    def __str__(self) -> str:
        return pgettext("piece", self.name)


class Find(models.Model):
    """An operator's report of a piece: what and where (m) it is. A moderator confirms which piece, or declines."""

    class State(models.TextChoices):
        """What a moderator has decided."""

        REPORTED = "reported", gettext_lazy("Waits for a moderator")
        CONFIRMED = "confirmed", gettext_lazy("Confirmed")
        DECLINED = "declined", gettext_lazy("Declined")

    round = models.ForeignKey(Round, models.CASCADE, related_name="finds")
    turn = models.ForeignKey(Turn, models.CASCADE, related_name="finds")
    author = models.ForeignKey(settings.AUTH_USER_MODEL, models.SET_NULL, null=True, related_name="finds")
    name = models.CharField(max_length=80)
    x = models.FloatField(gettext_lazy("x (m)"))
    y = models.FloatField(gettext_lazy("y (m)"))
    frame = models.ForeignKey("robots.Frame", models.SET_NULL, null=True, blank=True, related_name="finds")
    seen_at = models.DateTimeField(help_text=gettext_lazy("When the picture was taken; it decides who was first."))
    reported_at = models.DateTimeField()
    state = models.CharField(max_length=10, choices=State, default=State.REPORTED)
    piece = models.ForeignKey(Piece, models.SET_NULL, null=True, blank=True, related_name="finds")
    decided_by = models.ForeignKey(
        settings.AUTH_USER_MODEL, models.SET_NULL, null=True, blank=True, related_name="+", editable=False
    )
    decided_at = models.DateTimeField(null=True, blank=True, editable=False)

    class Meta:
        ordering = ("seen_at", "id")
        constraints = [
            models.CheckConstraint(
                condition=Q(piece__isnull=True) | Q(state="confirmed"), name="a_piece_of_a_confirmed_find"
            ),
        ]

    def __str__(self) -> str:
        return gettext("{find}, by {author}").format(find=self.name, author=shown_name(self.author_name))

    @property
    def author_name(self) -> str:
        """Return the author's handle, or that the account was deleted."""
        return handle_of(self.author)
