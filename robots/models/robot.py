"""A robot of the catalogue, and the rows of its use: grants, leases, commands, incidents, counters of use."""

import os
from collections.abc import Mapping
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from django.conf import settings
from django.db import models
from django.db.models import Q
from django.utils.crypto import salted_hmac
from django.utils.translation import gettext, gettext_lazy

from robots.kit import description
from robots.kit.contract.find import spec_of, spec_or_none
from robots.kit.contract.session import RobotState
from robots.kit.contract.spec import Spec
from robots.kit.contract.tidying import Tidy
from robots.models.recordings import Records
from robots.models.words import label_of, sentence_of
from robots.sentences import in_digits, translate
from robots.states import COMMAND_FINAL, CommandState, Cycle, GrantEnd, GrantKind, Lane
from robots.validators import a_turn, camera_addresses, microphone_address, robot_address

FRESH = timedelta(seconds=60)  # an older state is not used
LATER = timedelta(seconds=2)  # a state must be so much newer than a motion: it may be older than its row


class Robot(models.Model):
    """A robot in the catalogue: its address, its settings and its state in the turn cycle."""

    slug = models.SlugField(unique=True, max_length=40)
    name = models.CharField(max_length=80)
    tagline = models.CharField(max_length=200, blank=True)
    story = models.TextField(blank=True, help_text=gettext_lazy("Markdown, shown on the robot's page."))
    driver = models.CharField(max_length=40, default="mercury", help_text=gettext_lazy("Name of the driver package."))
    address = models.CharField(
        max_length=200,
        validators=[robot_address],
        help_text=gettext_lazy("sim:mercury, serial:/dev/ttyUSB0 or tcp:host:port"),
    )
    camera = models.TextField(
        blank=True,
        max_length=1000,
        validators=[camera_addresses],
        help_text=gettext_lazy(
            "Empty for a simulated robot; http://…/snapshot.jpg, rtsp://… or v4l2:/dev/video0, one camera a "
            "line in the order of the robot's cameras."
        ),
    )
    microphone = models.CharField(
        blank=True,
        default="",
        db_default="",
        max_length=300,
        validators=[microphone_address],
        help_text=gettext_lazy(
            "Empty: nobody hears anything. http(s)://…, rtsp://…, alsa:default, or sim:microphone for a "
            "simulated robot. Everybody who watches can listen: put up a notice where it stands."
        ),
    )
    enabled = models.BooleanField(default=False)
    cycle = models.CharField(max_length=12, choices=Cycle, default=Cycle.OFFLINE)
    reason = models.CharField(
        max_length=300, blank=True, help_text=gettext_lazy("Why it is not ready, in plain words.")
    )
    lockout_note = models.CharField(max_length=300, blank=True)
    locked_by = models.ForeignKey(
        settings.AUTH_USER_MODEL, models.SET_NULL, null=True, blank=True, related_name="+", editable=False
    )
    stop_latched = models.BooleanField(default=False, editable=False)
    releases = models.PositiveIntegerField(default=0, db_default=0, editable=False)  # number of releases of a stop
    stopped_at = models.DateTimeField(null=True, blank=True, editable=False)
    stopped_after = models.PositiveBigIntegerField(null=True, editable=False)  # the newest command at the last stop
    stop_confirmed = models.BooleanField(default=False, db_default=False, editable=False)  # the robot said it rests
    rests_by = models.DateTimeField(null=True, blank=True, editable=False)  # at the latest, where it did not say so
    silent_since = models.DateTimeField(null=True, blank=True, editable=False)  # while it is on without a worker
    turn_s = models.PositiveIntegerField(
        gettext_lazy("turn (s)"), null=True, blank=True, validators=[a_turn], help_text=gettext_lazy("Empty: default.")
    )
    practice_for = models.ForeignKey(
        "self", models.CASCADE, null=True, blank=True, related_name="twins",
        help_text=gettext_lazy(
            "The robot that people learn to drive here. This one is a simulator: it needs no clearance, and what "
            "is done with it is in no log."
        ),
    )  # fmt: skip
    guest_s = models.PositiveIntegerField(
        gettext_lazy("turn without an account (s)"), null=True, blank=True, validators=[a_turn],
        help_text=gettext_lazy("For practice only. Empty: people need an account."),
    )  # fmt: skip
    calibration = models.JSONField(default=dict, blank=True, editable=False)
    calibrated_at = models.DateTimeField(null=True, blank=True, editable=False)
    probe = models.JSONField(default=dict, blank=True, editable=False)
    probe_asked_at = models.DateTimeField(null=True, blank=True, editable=False)  # while a test is asked for
    probe_begun_at = models.DateTimeField(null=True, blank=True, editable=False)  # while it runs
    clearance_required = models.BooleanField(default=True)
    records = models.CharField(
        max_length=4, choices=Records, default=Records.OFF, db_default=Records.OFF,
        help_text=gettext_lazy(
            "Pictures, states, commands and events, shown to everybody who may see the turn or job."
        ),
    )  # fmt: skip
    recordings_keep_days = models.PositiveSmallIntegerField(
        gettext_lazy("recordings kept (days)"),
        null=True,
        blank=True,
        help_text=gettext_lazy("Then they are removed. Empty: default."),
    )
    recordings_limit_mb = models.PositiveIntegerField(
        gettext_lazy("limit of all recordings (MB)"),
        null=True,
        blank=True,
        help_text=gettext_lazy("The oldest are removed first. Empty: default."),
    )

    cheers = models.BooleanField(
        gettext_lazy("cheering"), default=True, db_default=True,
        help_text=gettext_lazy(
            "People who watch may cheer for who drives; everybody sees how many did. Not at practice."
        ),
    )  # fmt: skip
    settings = models.JSONField(default=dict, db_default={}, blank=True, editable=False)  # those that its spec declares

    class Meta:
        ordering = ("name",)
        constraints = [
            models.CheckConstraint(
                condition=Q(practice_for=None, guest_s=None)
                | Q(practice_for__isnull=False, address__startswith="sim:", clearance_required=False),
                name="practice_is_simulated",
                violation_error_message=gettext_lazy(
                    "A robot for practice is a simulator (sim:NAME) that requires no clearance, "
                    "and only a robot for practice has turns without an account."
                ),
            )
        ]

    def __str__(self) -> str:
        return self.name

    def get_absolute_url(self) -> str:
        """Return the address of the robot's page."""
        return f"/robots/{self.slug}/"

    @property
    def simulated(self) -> bool:
        """Return whether a program answers in the robot's place; everybody is told, but not by what address."""
        return self.address.startswith("sim:")

    @property
    def practice(self) -> bool:
        """Return whether people learn here to drive another robot."""
        return self.practice_for_id is not None

    @property
    def takes_cheers(self) -> bool:
        """Return whether people who watch may cheer for who drives."""
        return self.cheers and not self.practice

    @property
    def twin(self) -> "Robot | None":
        """Return the simulator on which people practise for this robot now; None if it has none."""
        return self.twins.filter(enabled=True).first()

    @property
    def full_name(self) -> str:
        """Return the name for texts, where no badge can stand."""
        return gettext("{name} (simulated)").format(name=self.name) if self.simulated else self.name

    def description(self) -> dict[str, Any]:
        """Return the parsed robot.toml."""
        return description.load(self.driver)

    def spec(self) -> Spec:
        """Return what the robot can do; its driver is not loaded. Raises LookupError."""
        return spec_of(self.driver)

    def readings(self, state: Mapping[str, Any]) -> tuple[tuple[str, float, str], ...]:
        """Return name, value and unit of what a kept state tells; nothing where the robot's package is gone."""
        try:
            return self.spec().readings(state)
        except LookupError:
            return ()

    def tidying_s(self) -> float:
        """Return how long the robot may tidy up between two turns (s); 0: it does not, or its package is gone."""
        spec = spec_or_none(self.driver)
        tidy = spec.capability(Tidy) if spec is not None else None
        return tidy.seconds(spec.for_driver(self.settings)) if spec is not None and tidy is not None else 0.0

    def driver_settings(self, epoch: int = 0) -> dict[str, Any]:
        """Return the settings handed to the driver of the owner with that epoch."""
        token = os.environ.get(f"FARHAND_TOKEN_{self.slug.upper().replace('-', '_')}")  # secrets are not stored in rows
        folder = str(Path(settings.VAR) / "robots" / self.slug)
        told = {"epoch": epoch, "folder": folder} | ({"token": token} if token else {})
        try:
            return told | self.spec().for_driver(self.settings)
        except LookupError:
            return told

    def camera_address(self, index: int) -> str:
        """Return the address of one of its cameras; empty for a simulated camera or one that it does not have."""
        addresses = self.camera.split()
        return addresses[index] if index < len(addresses) else ""

    @property
    def wire_address(self) -> str:
        """Return what the driver opens."""
        kind, _, rest = self.address.partition(":")
        if kind == "sim":
            return str(self.rig_dir / "tty")
        return rest if kind == "serial" else f"socket://{rest}"

    @property
    def rig_dir(self) -> Path:
        """Return the folder of a simulated robot, with its line, cameras and what its simulator keeps."""
        return Path(settings.VAR) / "sim" / self.slug

    @property
    def rig_secret(self) -> str:
        """Return the secret of this installation for a simulated robot: what it hides, nobody works out without it."""
        return salted_hmac("robots.rig", self.slug, algorithm="sha256").hexdigest()


class Grant(models.Model):
    """Permission to move one robot, from now on. A robot has at most one open grant."""

    robot = models.ForeignKey(Robot, models.CASCADE, related_name="grants")
    kind = models.CharField(max_length=10, choices=GrantKind)
    holder = models.ForeignKey(settings.AUTH_USER_MODEL, models.SET_NULL, null=True, blank=True, related_name="+")
    epoch = models.BigIntegerField(default=0)
    opened_at = models.DateTimeField()
    until = models.DateTimeField(null=True, blank=True)
    ended_at = models.DateTimeField(null=True, blank=True)
    end_code = models.CharField(max_length=12, choices=GrantEnd, blank=True)
    end_reason = models.CharField(max_length=120, blank=True)

    class Meta:
        constraints = [
            models.UniqueConstraint(fields=["robot"], condition=Q(ended_at=None), name="one_open_grant_a_robot")
        ]

    def __str__(self) -> str:
        return gettext("{kind} on {robot}").format(kind=self.get_kind_display(), robot=self.robot_id)


class Lease(models.Model):
    """The process that owns a robot; the epoch only ever grows."""

    robot = models.OneToOneField(Robot, models.CASCADE, related_name="lease")
    epoch = models.BigIntegerField(default=0)
    host = models.CharField(max_length=80, blank=True)
    pid = models.IntegerField(default=0)
    started = models.CharField(max_length=40, blank=True, help_text=gettext_lazy("Start time of that process."))
    expires_at = models.DateTimeField(null=True, blank=True)
    state = models.JSONField(default=dict, blank=True)
    state_at = models.DateTimeField(null=True, blank=True)

    def __str__(self) -> str:
        return gettext("epoch {number}").format(number=self.epoch)

    def present_state(self, spec: Spec, now: datetime) -> RobotState | None:
        """Return the state that the owner stored last; None where it is old or not whole. Checks of requests use it.

        Its `at` is not on any clock that is known here.
        """
        if self.state_at is None or now - self.state_at > FRESH:
            return None
        kept = self.state
        joints, pose = tuple(kept.get("joints") or ()), tuple(kept.get("pose") or ())
        if len(joints) != len(spec.joints) or len(pose) != (len(spec.pose.coordinates) if spec.pose else 0):
            return None
        moving, ready = bool(kept.get("moving")), bool(kept.get("ready"))
        return RobotState(0.0, joints, pose, moving, ready, values=kept.get("values") or {})

    def state_at_rest(self, spec: Spec, now: datetime, since: datetime) -> RobotState | None:
        """Return the same if the robot is at rest in it and it is newer than `since`, when the last motion ended."""
        state = self.present_state(spec, now)
        if state is None or state.moving or self.state_at is None or self.state_at < since + LATER:
            return None
        return state


class Usage(models.Model):
    """Five minutes of a robot: how long it was online, how many watched at once, and what was sent to them."""

    robot = models.ForeignKey(Robot, models.CASCADE, related_name="usage")
    at = models.DateTimeField(help_text=gettext_lazy("The beginning of the five minutes."))
    online_s = models.FloatField(default=0.0)
    watching = models.PositiveIntegerField(
        default=0, help_text=gettext_lazy("Most at once; the sum over all web processes.")
    )
    sent_bytes = models.BigIntegerField(default=0)

    class Meta:
        constraints = [models.UniqueConstraint(fields=["robot", "at"], name="one_usage_a_time")]

    def __str__(self) -> str:
        return f"{self.at:%Y-%m-%d %H:%M}"


class Command(models.Model):
    """One request to a robot. Services create rows; only the owner changes them."""

    robot = models.ForeignKey(Robot, models.CASCADE, related_name="commands")
    grant = models.ForeignKey(Grant, models.CASCADE, related_name="commands")
    client_seq = models.BigIntegerField()
    issued_by = models.ForeignKey(settings.AUTH_USER_MODEL, models.SET_NULL, null=True, related_name="+")
    kind = models.CharField(max_length=30)
    lane = models.CharField(max_length=8, choices=Lane, default=Lane.MOTION)
    args = models.JSONField(default=dict)
    epoch = models.BigIntegerField()
    state = models.CharField(max_length=12, choices=CommandState, default=CommandState.QUEUED)
    reason = models.CharField(max_length=300, blank=True)
    created_at = models.DateTimeField()
    deadline = models.DateTimeField()
    limit_s = models.FloatField(gettext_lazy("limit (s)"), default=15.0)
    accepted_at = models.DateTimeField(null=True, blank=True)
    sent_at = models.DateTimeField(null=True, blank=True)
    acknowledged_at = models.DateTimeField(null=True, blank=True)
    ended_at = models.DateTimeField(null=True, blank=True)
    result = models.JSONField(default=dict, blank=True)
    progress = models.JSONField(default=dict, blank=True)  # text, share (0 to 1 or None), at_ms
    # when the picture was taken that its sender saw, as the page said, and the newest that the robot's worker had taken
    seen_picture_at = models.DateTimeField(null=True, blank=True)
    newest_picture_at = models.DateTimeField(null=True, blank=True)
    clamping = models.JSONField(default=dict, db_default={}, blank=True)  # name: asked, sent, where they differ
    target = models.JSONField(default=dict, db_default={}, blank=True)  # words, place: see `target_of`

    class Meta:
        ordering = ("-id",)
        constraints = [models.UniqueConstraint(fields=["grant", "client_seq"], name="one_row_a_client_seq")]
        indexes = [
            models.Index(
                fields=["robot", "id"], condition=~Q(state__in=sorted(COMMAND_FINAL)), name="unfinished_commands"
            ),
            models.Index(fields=["robot", "kind", "id"], condition=Q(lane="config"), name="config_commands"),
            models.Index(fields=["robot", "ended_at"], name="commands_by_end"),  # statistics of a day
        ]

    def __str__(self) -> str:
        return f"{translate(label_of(self.robot.driver, self.kind))} #{self.pk}"

    @property
    def words(self) -> str:
        """Return what it does in a sentence, in the reader's language."""
        return translate(sentence_of(self.robot.driver, self.kind, self.args))

    @property
    def reached_at(self) -> datetime:
        """Return when the present stage was reached."""
        return self.ended_at or self.acknowledged_at or self.sent_at or self.accepted_at or self.created_at

    @property
    def picture_lag_s(self) -> float | None:
        """Return by how much the picture that its sender saw was older than the robot's newest (s); None: not known."""
        if self.seen_picture_at is None or self.newest_picture_at is None:
            return None
        return (self.newest_picture_at - self.seen_picture_at).total_seconds()

    @property
    def clamped_words(self) -> str:
        """Return what was sent instead of what was asked, as "speed 0.3 instead of 0.5"; empty if nothing differs.

        It is in the reader's language.
        """
        told = ((translate(name), in_digits(asked), in_digits(sent)) for name, (asked, sent) in self.clamping.items())
        said = gettext("{name} {sent} instead of {asked}")
        return ", ".join(said.format(name=name, sent=sent, asked=asked) for name, asked, sent in told)

    @property
    def final(self) -> bool:
        """Return whether the command has ended."""
        return self.state in COMMAND_FINAL


class Incident(models.Model):
    """A fault of a robot, kept for staff."""

    robot = models.ForeignKey(Robot, models.CASCADE, related_name="incidents")
    command = models.ForeignKey(Command, models.SET_NULL, null=True, blank=True)
    at = models.DateTimeField()
    code = models.CharField(max_length=40)
    text = models.CharField(max_length=300)
    remedy = models.CharField(max_length=300, blank=True, help_text=gettext_lazy("What the portal did about it."))
    closed_at = models.DateTimeField(null=True, blank=True)

    class Meta:
        ordering = ("-at",)

    def __str__(self) -> str:
        return translate(self.text)
