"""The controls of a held motion on one page: pressed, held, released; they reach the owner without the database."""

from math import inf

from portal.live.messages import Command, Keep, Released
from portal.live.threads import URGENT
from robots import bus
from robots.kit.clock import SYSTEM

HEARD_S = 0.1  # a page reports more often than this that its controls are held


class HeldControls:
    """The controls of one page, which belong to the motion that this page began, whatever other pages do."""

    def __init__(self, slug: str) -> None:
        self._slug = slug
        self.kinds: frozenset[str] | None = None  # the kinds of held motions; None: not known, so each may be one
        self._pressed = self._command = 0  # the number of the motion that is pressed; its command, once written
        self._heard_at = -inf  # when the page reported last that its controls are held or released

    def is_held(self, command: Command) -> bool:
        """Return whether a command lasts while its controls are held."""
        return self.kinds is None or command.kind in self.kinds

    def press(self, command: Command) -> None:
        """Note a motion that is asked for.

        Whether the person drives is judged where the command is written: the last snapshot may be older than the press.
        """
        if self.is_held(command):
            self._pressed, self._command, self._heard_at = command.seq, 0, SYSTEM.monotonic()

    async def hear(self, message: Keep | Released) -> None:
        """Pass on that the controls are held or were released; before the command is written, note it for `assign`."""
        if message.seq != self._pressed:
            return
        command, held = self._command, isinstance(message, Keep)
        self._heard_at = SYSTEM.monotonic()
        if not held:
            self._pressed = self._command = 0
        if command:
            await self._send(command, held, message.args if isinstance(message, Keep) else {})

    async def assign(self, message: Command, command: int) -> None:
        """Hold the motion that this page began, whose command (0: none was written) is known only now."""
        if not self.is_held(message):
            return
        pressed = message.seq == self._pressed
        if pressed:
            self._pressed, self._command = message.seq if command else 0, command
        if command and not (pressed and SYSTEM.monotonic() - self._heard_at > HEARD_S):
            await self._send(command, held=pressed)

    async def release(self) -> None:
        """Release the controls because the page is gone."""
        if self._command:
            await self._send(self._command, held=False)

    async def _send(self, command: int, held: bool, args: dict[str, int | float] | None = None) -> None:
        await URGENT.run(bus.send_keep_alive, self._slug, command, held, args or {})
