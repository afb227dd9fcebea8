"""Soft reset: after a fault the driver resets the robot, in its own way."""

from robots import bus
from robots.drivers.errors import HardwareFault, NotPermitted, RobotError
from robots.messages import Notice
from robots.models import Command
from workers.cameras.look import look
from workers.cameras.pictures import Pictures
from workers.incidents import incident
from workers.owned import OwnedRobot
from workers.safety.gate import Gate
from workers.safety.lease import OwnerLease

MENDED = "Reset by its driver."


class Recovery:
    """Resets one robot, records the incident and informs the operator."""

    def __init__(self, owned: OwnedRobot, lease: OwnerLease, gate: Gate, pictures: Pictures) -> None:
        self._owned, self._lease, self._gate, self._pictures = owned, lease, gate, pictures

    def soft_reset(self, cause: HardwareFault, command: Command | None) -> bool:
        """Reset after `cause`, which happened during `command`. Return whether it worked."""
        owned, slug = self._owned, self._owned.robot.slug
        kept = incident(owned.robot, cause.code, str(cause), owned.now(), command)

        def remedy(text: str) -> None:
            kept.remedy = text[:300]
            kept.save(update_fields=["remedy"])

        permit = self._gate.bound(command.epoch if command else self._lease.epoch)
        try:
            permit()
        except NotPermitted as error:
            remedy(f"No soft reset: {error}")
            return False
        bus.publish(slug, Notice(f"{cause} The controller is being reset.", "warning"))
        try:
            self._pictures.still_id = 0
            state = owned.driver.recover(permit)
        except RobotError as error:
            remedy(f"The soft reset failed: {error}")
            bus.publish(slug, Notice(f"The soft reset failed: {error}", "error"))
            return False
        remedy(MENDED)
        look(owned, self._pictures, state, command)
        bus.publish(slug, Notice("The robot was reset and may stand elsewhere. Look, then go on.", "info"))
        return True
