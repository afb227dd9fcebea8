"""The path of a motion that the robot has accepted, published once, so that viewers draw it before the states come."""

from robots import bus
from robots.kit.contract.compact import Layout
from robots.kit.contract.path_packet import BegunPath, encode_path
from robots.kit.contract.session import Moves
from robots.models import Command
from workers.robot.owned import OwnedRobot


class PathReporter:
    """Publishes paths, and keeps the one that runs for viewers that come later."""

    def __init__(self, owned: OwnedRobot) -> None:
        self._owned = owned
        self._kept = 0  # the command whose path is kept

    def report(self, command: Command, moves: Moves) -> None:
        """Publish the path of a command. A robot without a compact layout, or a path too long for a packet, has none.

        Without Redis the path is lost: it only makes viewers see sooner what the states tell.
        """
        owned = self._owned
        layout = Layout.of(owned.robot.spec())
        if layout is None:
            return
        began_ms = int((owned.now().timestamp() - owned.since(moves.at)) * 1000)
        packet = encode_path(layout, BegunPath(command.pk, began_ms, moves.path))
        left_s = moves.path.seconds - owned.since(moves.at)
        if packet is not None and left_s > 0 and bus.publish_path(owned.robot.slug, packet, left_s):
            self._kept = command.pk

    def end(self, command: Command) -> None:
        """Keep the path of a command that has ended no longer."""
        if self._kept == command.pk:
            self._kept = 0
            bus.forget_path(self._owned.robot.slug)
