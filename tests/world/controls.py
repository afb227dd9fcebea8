"""Somebody who holds the controls of held motions, one after another."""

from math import inf

from robots import bus
from robots.models import Command
from robots.prepared import Prepared, Slot
from robots.states import COMMAND_FINAL, COMMAND_RUNNING
from tests.world.world import World

EVERY_S = 0.06
UNKNOWN_S = 5.0  # after a command was claimed: that it was acknowledged may be lost with the database
_STATE: Prepared[Command] = Prepared(lambda: Command.objects.filter(pk=Slot("command", Command._meta.pk)).only("state"))


def state_of(command: Command) -> str:
    """Return the command's state, as its row has it now."""
    return _STATE(command=command.pk)[0].state


class Controls:
    """Keep-alives for the oldest command that is not over, until `moment_s` after it was acknowledged.

    Where that is lost, `UNKNOWN_S` after it was claimed counts. `last` is when the newest was sent (monotonic, s).
    """

    moment_s = 1.0

    def __init__(self, world: World) -> None:
        self._world, self._held, self.last = world, [], 0.0
        self.args: dict[str, float] = {}  # newer values that they carry
        self._begun = False

    def hold(self, command: Command) -> Command:
        """Hold the controls for a command once it is its turn."""
        self._held.append(command)
        if not self._begun:
            self._begun = True
            self._world.spawn(self._run, "controls")
        return command

    def let_go(self) -> None:
        """Say nothing more, as a browser does that is gone."""
        self._held.clear()

    def _run(self) -> None:
        claimed, since, told = inf, inf, None
        while True:
            held = [one for one in self._held if state_of(one) not in COMMAND_FINAL]
            self._held = held
            if held:
                now, command = self._world.monotonic(), held[0]
                if command is not told:
                    claimed, since, told = inf, inf, command
                if since == inf:
                    state = state_of(command)
                    claimed = min(claimed, now) if state in COMMAND_RUNNING else inf
                    since = now if state == "acknowledged" or now - claimed > UNKNOWN_S else inf
                self.last = now
                bus.send_keep_alive(command.robot.slug, command.pk, now - since < self.moment_s, self.args)
            self._world.sleep(EVERY_S)
