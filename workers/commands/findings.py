"""The findings of commands, stored first on this machine, then in the database: each exactly once.

A finding is a small file until its row is committed, so a database that is away, or a process that is killed, loses
none. The row's number is unique for its command: a file that is read again after its row was committed adds nothing.
"""

import contextlib
import json
import logging
from datetime import datetime
from pathlib import Path
from typing import Any

from django.db import Error, close_old_connections, transaction

from robots import bus
from robots.kit.contract.channels import MOST as MOST_VALUES
from robots.kit.contract.channels import finite, whole
from robots.kit.contract.errors import CameraFault
from robots.kit.contract.session import Observation, RobotState
from robots.kit.files import replaced
from robots.kit.packets import Changed
from robots.kit.plain import one_line
from robots.models import Command, Finding, Frame
from workers.media.pictures import Pictures
from workers.robot.owned import OwnedRobot

log = logging.getLogger(__name__)
MOST, MOST_PICTURES = 500, 1000  # findings of a command without a picture, and with one
LONGEST = 200  # characters of one
AGAIN_S = 2.0  # between two tries while the database is away
FULL = "The picture could not be stored: the disk may be full."
SPENT = "No more readings of this command are stored."
SPENT_PICTURES = "No more pictures of this command are stored."


class Findings:
    """The findings of one robot's commands. `folder` is where they wait for the database."""

    def __init__(self, owned: OwnedRobot, pictures: Pictures, folder: Path) -> None:
        self._owned, self._pictures, self._folder = owned, pictures, folder
        self._command = self._number = 0
        self._noted, self._left_out = [0, 0], 0  # of that command: findings without a picture and with one
        self._again_at = 0.0
        self._waits = True  # files may be there: an earlier owner may have left some

    def note(self, command: Command, noted: Observation) -> None:
        """Store what a command has found, with a picture where it asks for one. What fails ends no motion."""
        if command.pk != self._command:
            self._command, self._number = command.pk, 0
            self._noted, self._left_out = [0, 0], 0
        most, spent = ((MOST, SPENT), (MOST_PICTURES, SPENT_PICTURES))[noted.photograph]
        self._noted[noted.photograph] += 1
        if self._noted[noted.photograph] > most:
            self._left_out += 1
            if self._noted[noted.photograph] > most + 1:
                return
            noted = Observation(spent)
        self._number += 1
        state = self._owned.driver.latest() or RobotState(0.0, (), (), False, False)
        text, frame = noted.text, None
        if noted.photograph:
            try:
                frame = self._pictures.photograph(state)
                text = text if frame else f"{text}: {FULL}"
            except CameraFault as error:
                text = f"{text}: {error}"
        told = {
            "command": command.pk, "grant": command.grant_id, "number": self._number,
            "at": self._owned.now().isoformat(), "text": one_line(text)[:LONGEST],
            "values": dict(list(finite(noted.values).items())[:MOST_VALUES]), "pose": whole(state.pose),
            "frame": frame and {**frame, "taken_at": frame["taken_at"].isoformat()},
        }  # fmt: skip
        if self._waiting(told):
            self._waits, self._again_at = True, 0.0
            self.register()
        else:
            self._stored(told)

    def left_out(self, command: Command) -> int:
        """Return how many findings of a command were not stored, because there were too many."""
        return self._left_out if command.pk == self._command else 0

    def _waiting(self, told: dict[str, Any]) -> bool:
        """Write the finding to this machine; tell whether that worked."""
        path = self._folder / f"{told['command']}-{told['number']:05d}.json"
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            with replaced(path, sync=True) as out:
                out.write(json.dumps(told).encode())
        except OSError as error:
            log.error("a finding could not be written to the disk: %s", error)
            return False
        return True

    def register(self) -> None:
        """Store in the database what waits on this machine. While the database is away it waits on."""
        if not self._waits or self._owned.clock.monotonic() < self._again_at:
            return
        for path in sorted(self._folder.glob("*.json")):
            try:
                told = json.loads(path.read_bytes())
            except (OSError, ValueError) as error:
                log.error("a finding cannot be read and is left aside: %s", error)
                with contextlib.suppress(OSError):
                    path.rename(path.with_suffix(".unreadable"))
                continue
            if not self._stored(told):
                self._again_at = self._owned.clock.monotonic() + AGAIN_S
                return
            path.unlink(missing_ok=True)
        self._waits = False

    def _stored(self, told: dict[str, Any]) -> bool:
        """Store one finding, unless its row is there already; tell whether the database answered."""
        try:
            with transaction.atomic():
                command = Command.objects.select_related("robot").filter(pk=told["command"]).first()
                if command is not None:
                    _insert(command, told)
        except Error as error:
            log.warning("a finding of command %s waits for the database: %s", told["command"], error)
            close_old_connections()
            return False
        bus.publish(self._owned.robot.slug, Changed("frame"))
        return True


def _insert(command: Command, told: dict[str, Any]) -> None:
    """Add the row, and that of its picture, unless they are there. Inside a transaction."""
    made, new = Finding.objects.get_or_create(
        command=command, number=told["number"],
        defaults={
            "at": datetime.fromisoformat(told["at"]), "text": told["text"], "values": told["values"],
            "pose": told["pose"],
        },
    )  # fmt: skip
    fields = told["frame"]
    if new and fields is not None:
        taken_at = datetime.fromisoformat(fields["taken_at"])
        row = {**fields, "taken_at": taken_at}
        made.frame = Frame.objects.create(robot=command.robot, grant_id=told["grant"], command=command, **row)
        made.save(update_fields=["frame"])
