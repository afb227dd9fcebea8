"""Previews for one page: its newest question, and the newest answer."""

import asyncio

from portal.live.messages import Plan
from portal.live.previews import Question
from portal.live.socket import Socket


class PlanSender:
    """Asks for previews of where commands would lead, and sends the answers; one that is overtaken is dropped."""

    def __init__(self, socket: Socket, slug: str) -> None:
        self._socket, self._slug = socket, slug
        self._text = ""
        self._answered = asyncio.Event()
        self._sending = False

    @property
    def closed(self) -> bool:
        """Return whether nobody waits for an answer any more."""
        return self._socket.closed

    def ask(self, message: Plan) -> None:
        """Ask for a preview."""
        self._socket.shared.previews.ask(
            self._socket.role.person, Question(self, self._socket.scope, self._slug, message)
        )

    def answer(self, text: str) -> None:
        """Send an answer soon."""
        self._text = text
        self._answered.set()
        if not self._sending:
            self._sending = True
            self._socket.begin(self._run())

    async def _run(self) -> None:
        while True:
            await self._answered.wait()
            self._answered.clear()
            text, self._text = self._text, ""
            await self._socket.send(text)
