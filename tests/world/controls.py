"""Somebody who holds the controls of held motions, one after another, until they end or are let go."""

from robots import bus
from robots.models import Command
from robots.states import COMMAND_FINAL

EVERY_S = 0.06


class Controls:
    """Keep-alives for the oldest of the commands that are held and not over; `last` is when the newest was sent (s)."""

    def __init__(self, world) -> None:
        self._world, self._held, self.last = world, [], 0.0
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
        while True:
            while self._held and Command.objects.get(pk=self._held[0].pk).state in COMMAND_FINAL:
                self._held.pop(0)
            if self._held:
                bus.send_keep_alive(self._held[0].robot.slug, self._held[0].pk, True)
                self.last = self._world.monotonic()
            self._world.sleep(EVERY_S)
