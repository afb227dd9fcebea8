"""The catalogue of robots: a robot with its address, its settings and its state in the turn cycle."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from django.conf import settings
from django.db import models

from robots.kit import description
from robots.kit.contract.find import spec_of
from robots.kit.contract.spec import Spec
from robots.models.recordings import Records
from robots.states import Cycle
from robots.validators import a_turn, camera_addresses, microphone_address, robot_address


class Robot(models.Model):
    """A robot in the catalogue: its address, its settings and its state in the turn cycle."""

    slug = models.SlugField(unique=True, max_length=40)
    name = models.CharField(max_length=80)
    tagline = models.CharField(max_length=200, blank=True)
    story = models.TextField(blank=True, help_text="Markdown, shown on the robot's page.")
    driver = models.CharField(max_length=40, default="mercury", help_text="Name of the driver package.")
    address = models.CharField(
        max_length=200,
        validators=[robot_address],
        help_text="sim:mercury, serial:/dev/ttyUSB0 or tcp:host:port",
    )
    camera = models.TextField(
        blank=True,
        max_length=1000,
        validators=[camera_addresses],
        help_text="Empty for a simulated robot; http://…/snapshot.jpg, rtsp://… or v4l2:/dev/video0, one camera a "
        "line in the order of the robot's cameras.",
    )
    microphone = models.CharField(
        blank=True,
        default="",
        db_default="",
        max_length=300,
        validators=[microphone_address],
        help_text="Empty: nobody hears anything. http(s)://…, rtsp://…, alsa:default, or sim:microphone for a "
        "simulated robot. Everybody who watches can listen: put up a notice where it stands.",
    )
    enabled = models.BooleanField(default=False)
    cycle = models.CharField(max_length=12, choices=Cycle, default=Cycle.OFFLINE)
    reason = models.CharField(max_length=300, blank=True, help_text="Why it is not ready, in plain words.")
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
    turn_s = models.PositiveIntegerField(
        "turn (s)", null=True, blank=True, validators=[a_turn], help_text="Empty: default."
    )
    calibration = models.JSONField(default=dict, blank=True, editable=False)
    calibrated_at = models.DateTimeField(null=True, blank=True, editable=False)
    probe = models.JSONField(default=dict, blank=True, editable=False)
    probe_asked_at = models.DateTimeField(null=True, blank=True, editable=False)  # while a test is asked for
    probe_begun_at = models.DateTimeField(null=True, blank=True, editable=False)  # while it runs
    clearance_required = models.BooleanField(default=True)
    records = models.CharField(
        max_length=4, choices=Records, default=Records.OFF, db_default=Records.OFF,
        help_text="Pictures, states, commands and events, shown to everybody who may see the turn or job.",
    )  # fmt: skip
    recordings_keep_days = models.PositiveSmallIntegerField(
        "recordings kept (days)", null=True, blank=True, help_text="Then they are removed. Empty: default."
    )
    recordings_limit_mb = models.PositiveIntegerField(
        "limit of all recordings (MB)", null=True, blank=True, help_text="The oldest are removed first. Empty: default."
    )

    settings = models.JSONField(default=dict, db_default={}, blank=True, editable=False)  # those that its spec declares

    class Meta:
        ordering = ("name",)

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
    def full_name(self) -> str:
        """Return the name for texts, where no badge can stand."""
        return f"{self.name} (simulated)" if self.simulated else self.name

    def description(self) -> dict[str, Any]:
        """Return the parsed robot.toml."""
        return description.load(self.driver)

    def spec(self) -> Spec:
        """Return what the robot can do; its driver is not loaded. Raises LookupError."""
        return spec_of(self.driver)

    def readings(self, kept: Mapping[str, Any]) -> tuple[tuple[str, float, str], ...]:
        """Return name, value and unit of what a kept state tells; nothing where the robot's package is gone."""
        try:
            return self.spec().readings(kept)
        except LookupError:
            return ()

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
