"""After a fault: the driver resets the robot in its own way, or connects to it anew if it has no reset."""

from robots import bus
from robots.kit.contract.capabilities import Reset
from robots.kit.contract.errors import HardwareFault, NotPermitted, RobotError
from robots.kit.packets import Notice
from robots.models import Command
from robots.services.incidents import incident
from workers.authority.gate import Gate
from workers.media.pictures import Pictures
from workers.robot.look import look
from workers.robot.owned import OwnedRobot

RESET = "The robot is being reset.", "The reset failed"
CONNECTION = "The robot is being connected anew.", "The new connection failed"
MENDED, ANEW = "Reset by its driver.", "Connected anew by its driver."


BACK = "The robot was reset and may stand elsewhere. Look, then go on."
ANSWERS = "The robot answers again. Look, then go on."


class Recovery:
    """Recovers one robot, records the incident and informs the operator."""

    def __init__(self, owned: OwnedRobot, gate: Gate, pictures: Pictures) -> None:
        self._owned, self._gate, self._pictures = owned, gate, pictures

    def moves(self) -> None:
        """Note that the robot moves, so that its last picture shows it where it no longer is."""
        self._pictures.still_id = 0

    @property
    def _resets(self) -> bool:
        return self._owned.robot.spec().capability(Reset) is not None

    @property
    def words(self) -> str:
        """Return what the operator is told after a recovery that worked."""
        return BACK if self._resets else ANSWERS

    def recover(self, cause: HardwareFault, command: Command) -> bool:
        """Recover after `cause`, which happened during `command`. Return whether it worked."""
        owned, slug = self._owned, self._owned.robot.slug
        kept = incident(owned.robot, cause.code, str(cause), owned.now(), command)

        def remedy(text: str) -> None:
            kept.remedy = text[:300]
            kept.save(update_fields=["remedy"])

        permit = self._gate.permit(command.epoch)
        try:
            permit()
        except NotPermitted as error:
            remedy(f"Not tried: {error}")
            return False
        resets = self._resets
        doing, failed = RESET if resets else CONNECTION
        bus.publish(slug, Notice(f"{cause} {doing}", "warning"))
        try:
            self.moves()
            state = owned.driver.recover(permit)
        except RobotError as error:
            remedy(f"{failed}: {error}")
            bus.publish(slug, Notice(f"{failed}: {error}", "error"))
            return False
        remedy(MENDED if resets else ANEW)
        look(owned, self._pictures, state, command)
        bus.publish(slug, Notice(self.words, "info"))
        return True
