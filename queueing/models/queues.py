"""Queues, tickets and turns."""

from django.conf import settings
from django.db import models
from django.db.models import Q
from django.utils.timezone import localtime
from django.utils.translation import gettext, gettext_lazy

from robots.people import handle_of, shown_name
from robots.validators import positive


class TicketState(models.TextChoices):
    """The states of a place in the queue."""

    WAITING = "waiting", gettext_lazy("Waiting")
    OFFERED = "offered", gettext_lazy("Offered")
    OPERATING = "operating", gettext_lazy("Operating")
    DONE = "done", gettext_lazy("Done")
    LEFT = "left", gettext_lazy("Left")
    EXPIRED = "expired", gettext_lazy("Expired")


OPEN_TICKET = (TicketState.WAITING, TicketState.OFFERED, TicketState.OPERATING)
NOT_YET = (TicketState.WAITING, TicketState.OFFERED)


class PlaceEnd(models.TextChoices):
    """Why a place ended that never became a turn: `end_reason` of its ticket."""

    NO_ANSWER = "did not answer the offer"
    AWAY = "was away too long"
    LEFT = "left the queue"
    REMOVED = "removed by staff"
    SUSPENDED = "account suspended"
    UNCLEARED = "clearance withdrawn"
    DELETED = "account deleted"


class Charge(models.TextChoices):
    """The unit in which the use of a robot is charged."""

    SECONDS = "seconds", gettext_lazy("Seconds")
    JOBS = "jobs", gettext_lazy("Jobs")


class Queue(models.Model):
    """A queue for one robot, or for several equal robots."""

    name = models.CharField(max_length=80)
    paused = models.BooleanField(default=False, help_text=gettext_lazy("Nobody is offered the robot; places are kept."))
    guest_weight = models.FloatField(
        default=1.0, validators=[positive],
        help_text=gettext_lazy("Of each network address from which guests ask for jobs; a person has 1."),
    )  # fmt: skip
    virtual_time = models.FloatField(default=0.0, editable=False)
    greatest_finish = models.FloatField(default=0.0, editable=False)

    def __str__(self) -> str:
        robot = self.name.removeprefix("Queue of ")  # the name that a new robot's queue has
        return self.name if robot == self.name else gettext("Queue of {robot}").format(robot=robot)


class QueueRobot(models.Model):
    """A robot in its queue; a robot has one queue."""

    robot = models.OneToOneField("robots.Robot", models.CASCADE, related_name="queue_link")
    queue = models.ForeignKey(Queue, models.CASCADE, related_name="robot_links")
    offers_turns = models.BooleanField(
        default=True, help_text=gettext_lazy("People may drive it; without, it takes jobs only.")
    )
    guests_ask = models.BooleanField(
        default=False, help_text=gettext_lazy("Jobs may be asked for without account or clearance.")
    )
    charged_in = models.CharField(
        max_length=8,
        choices=Charge,
        default=Charge.SECONDS,
        help_text=gettext_lazy("Of jobs; where turns are offered too: seconds."),
    )
    rest_after_min = models.PositiveSmallIntegerField(
        gettext_lazy("idle behaviour rests after (min)"), null=True, blank=True, default=15,
        help_text=gettext_lazy("Of nobody watching; empty: never."),
    )  # fmt: skip
    watched_at = models.DateTimeField(null=True, blank=True, editable=False)
    resumed_at = models.DateTimeField(null=True, blank=True, editable=False)  # when staff resumed after the last stop

    class Meta:
        verbose_name = gettext_lazy("robot")

    def __str__(self) -> str:
        return gettext("{robot} in {queue}").format(robot=self.robot, queue=self.queue)

    @property
    def charges_jobs(self) -> bool:
        """Return whether a job costs 1, and not the seconds that it took."""
        return self.charged_in == Charge.JOBS and not self.offers_turns


class Account(models.Model):
    """The use of a queue by a person, or by all guests of one network address: finish tag and weight."""

    queue = models.ForeignKey(Queue, models.CASCADE, related_name="accounts")
    user = models.ForeignKey(settings.AUTH_USER_MODEL, models.CASCADE, null=True, blank=True, related_name="+")
    network = models.CharField(max_length=64, blank=True, help_text=gettext_lazy("Of guests; empty for a person."))
    finish_tag = models.FloatField(gettext_lazy("finish tag (s or jobs)"), default=0.0)
    weight = models.FloatField(
        null=True, blank=True, validators=[positive],
        help_text=gettext_lazy(
            "Its share of the robot beside others; empty: 1 for a person, for guests what the queue says."
        ),
    )  # fmt: skip

    class Meta:
        constraints = [
            models.UniqueConstraint(fields=["queue", "user"], name="one_account_a_queue"),
            models.UniqueConstraint(
                fields=["queue", "network"], condition=~Q(network=""), name="one_account_a_network"
            ),
        ]
        verbose_name, verbose_name_plural = gettext_lazy("share of a queue"), gettext_lazy("shares of queues")

    def __str__(self) -> str:
        if self.user is None:
            return gettext("guests in {queue}").format(queue=self.queue)
        return gettext("{user} in {queue}").format(user=self.user, queue=self.queue)

    def weighs(self, queue: Queue) -> float:
        """Return the weight in force; `queue` is the account's."""
        if self.weight is not None:
            return self.weight
        return queue.guest_weight if self.user_id is None else 1.0


class Ticket(models.Model):
    """A person's place in a queue."""

    queue = models.ForeignKey(Queue, models.CASCADE, related_name="tickets")
    user = models.ForeignKey(settings.AUTH_USER_MODEL, models.CASCADE, related_name="tickets")
    state = models.CharField(max_length=10, choices=TicketState, default=TicketState.WAITING)
    start_tag = models.FloatField(gettext_lazy("start tag (s or jobs)"))
    joined_at = models.DateTimeField()
    last_seen = models.DateTimeField()
    classic = models.BooleanField(default=False, help_text=gettext_lazy("Uses the console without scripts."))
    robot = models.ForeignKey("robots.Robot", models.SET_NULL, null=True, blank=True, related_name="+")
    offer_until = models.DateTimeField(
        null=True,
        blank=True,
        help_text=gettext_lazy(
            "Of a place that waits: when an offer ended that the person, who was away, did not answer."
        ),
    )
    push_due = models.BooleanField(
        default=False, db_default=False, editable=False
    )  # browsers are not told of the offer yet
    mail_due = models.BooleanField(
        default=False, db_default=False, editable=False
    )  # while it is offered: no mail tells of the offer yet
    ended_at = models.DateTimeField(null=True, blank=True)
    end_reason = models.CharField(max_length=80, blank=True)
    dismissed_at = models.DateTimeField(
        null=True, blank=True, help_text=gettext_lazy("The person has read that the place was lost.")
    )

    class Meta:
        constraints = [
            models.UniqueConstraint(
                fields=["queue", "user"], condition=Q(state__in=OPEN_TICKET), name="one_open_ticket_a_person"
            )
        ]
        indexes = [
            models.Index(fields=["queue", "state", "start_tag", "id"], name="served_in_tag_order"),
            models.Index(fields=["offer_until"], condition=Q(push_due=True), name="offers_push_due"),
            models.Index(fields=["offer_until"], condition=Q(mail_due=True), name="offers_mail_due"),
        ]
        verbose_name, verbose_name_plural = gettext_lazy("place in a queue"), gettext_lazy("places in queues")

    def __str__(self) -> str:
        return f"{self.user} ({self.get_state_display()})"


class Turn(models.Model):
    """A turn of a person on a robot; it has a permanent page, which outlives the person's account and its ticket."""

    robot = models.ForeignKey("robots.Robot", models.CASCADE, related_name="turns")
    user = models.ForeignKey(settings.AUTH_USER_MODEL, models.SET_NULL, null=True, related_name="turns")
    ticket = models.OneToOneField(Ticket, models.SET_NULL, null=True, related_name="turn")
    grant = models.OneToOneField("robots.Grant", models.CASCADE, related_name="turn")
    classic = models.BooleanField(default=False)
    started_at = models.DateTimeField()
    base_until = models.DateTimeField()
    until = models.DateTimeField()
    last_seen = models.DateTimeField()
    connected = models.BooleanField(default=True)
    acted_at = models.DateTimeField(
        null=True,
        blank=True,
        help_text=gettext_lazy("When the operator last did something beside commands, or said so."),
    )
    ended_at = models.DateTimeField(null=True, blank=True)
    end_reason = models.CharField(max_length=80, blank=True)
    alone_s = models.FloatField(gettext_lazy("nobody waited for (s)"), default=0.0)
    charged_s = models.FloatField(gettext_lazy("charged (s)"), null=True, blank=True)

    class Meta:
        ordering = ("-id",)
        constraints = [
            models.UniqueConstraint(fields=["robot"], condition=Q(ended_at=None), name="one_operator_a_robot"),
            models.UniqueConstraint(fields=["user"], condition=Q(ended_at=None), name="one_robot_an_operator"),
        ]

    def __str__(self) -> str:
        words = gettext("turn {number}: {operator} on {robot}")
        return words.format(number=self.pk, operator=shown_name(self.operator_name), robot=self.robot)

    def get_absolute_url(self) -> str:
        """Return the turn's permanent address."""
        return f"/turns/{self.pk}/"

    @property
    def operator_name(self) -> str:
        """Return the operator's handle, or that the account was deleted."""
        return handle_of(self.user)


class LostCause(models.TextChoices):
    """Why an operator's connection was lost."""

    PAGE = "page", gettext_lazy("The page was closed, left or reloaded")
    CUT = "cut", gettext_lazy("The connection was cut on its way")
    NO_PONG = "no_pong", gettext_lazy("The browser did not answer for 20 seconds")
    NOT_READ = "not_read", gettext_lazy("The browser took no data for a minute")
    RESTART = "restart", gettext_lazy("The portal was restarted")


SIDES = {
    LostCause.PAGE: gettext_lazy("browser"),
    LostCause.CUT: gettext_lazy("network"),
    LostCause.NO_PONG: gettext_lazy("browser or network"),
    LostCause.NOT_READ: gettext_lazy("browser or network"),
    LostCause.RESTART: gettext_lazy("portal"),
}


class LostConnection(models.Model):
    """A connection of an operator that ended during the turn."""

    turn = models.ForeignKey(Turn, models.CASCADE, related_name="lost_connections")
    at = models.DateTimeField()
    cause = models.CharField(max_length=8, choices=LostCause)

    class Meta:
        ordering = ("-id",)

    def __str__(self) -> str:
        return f"{localtime(self.at):%Y-%m-%d %H:%M:%S}: {self.get_cause_display()}"

    @property
    def side(self) -> str:
        """Return on which side the cause was."""
        return str(SIDES[LostCause(self.cause)])


class TurnSession(models.Model):
    """A session of the operator in which the robot's page is open, and when that page last reported."""

    turn = models.ForeignKey(Turn, models.CASCADE, related_name="sessions")
    session = models.CharField(max_length=40, help_text=gettext_lazy("The key of the session."))
    last_seen = models.DateTimeField()

    class Meta:
        constraints = [models.UniqueConstraint(fields=["turn", "session"], name="each_session_of_a_turn_once")]

    def __str__(self) -> str:
        return gettext("a session of {turn}").format(turn=self.turn)
