"""The person's socket, one for each open page: it sends the person's places in queues and notes their presence.

The server asks and the page answers (`here`), because browsers run the timers of a page in the
background at most once a minute, but deliver messages at once. For the same reason the places are
sent again when the page has to announce something: 60, 20 and 10 s before an end.
"""

import asyncio
import contextlib
import json
from typing import Any

from django.db import Error

from portal.live.messages import PERSON, Do, Here, Look, NotUnderstood, PersonMessage
from portal.live.people import Role, current_user, session_key
from portal.live.sessions import sign_in_of
from portal.live.socket import Socket
from portal.live.standing import act, places
from portal.live.subscriptions import Subscriber
from portal.stores import down_text
from queueing.services import note_open_session, note_waiting, standings
from robots.kit.clock import SYSTEM

PULSE_S = 20.0
UNLINKED_S = 2.0  # between two queries while Redis is away
SEEN_S = 10.0  # between two notes of presence
LEAST_S = 0.2  # the least pause between two queries, however often something changes
MOMENTS_S = (60, 20, 10, 0)
SIGNED_OUT = 4401


class PersonSocket(Socket):
    """One page of one person who is signed in."""

    wire = PERSON

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._subscriber: Subscriber | None = None
        self._waits, self._seen = False, 0.0

    async def open(self) -> None:
        """Read the person of the session; the socket closes if nobody is signed in."""
        try:
            user = await self.orm(current_user, self.scope)
        except Error:
            await self.close(1013)  # try again later
            return
        if not user.is_authenticated:
            await self.close(SIGNED_OUT)
            return
        self.role = Role(user.pk)
        self.sign(sign_in_of(self.scope, user))
        self._subscriber = Subscriber(user.pk)
        self.shared.people.attach(self._subscriber)
        self.begin(self._serve(self._subscriber))

    async def release(self) -> None:
        """Remove the subscription."""
        if self._subscriber is not None:
            self.shared.people.detach(self._subscriber)

    async def take(self, message: PersonMessage) -> None:
        """Note the presence, send the places again, or carry out a request."""
        subscriber = self._subscriber
        if subscriber is None:
            return
        match message:
            case Here():
                if self._waits and SYSTEM.awake() - self._seen > SEEN_S:
                    self._seen = SYSTEM.awake()
                    with contextlib.suppress(Error):  # the next answer of the page notes it again
                        await self.orm(self._present)
            case Look():
                subscriber.changed.set()
            case Do():
                try:
                    wrong = await self.orm(self._act, message)
                except Error as error:
                    wrong = down_text(error)
                await self._answer(message.what, message.robot, wrong)
                subscriber.changed.set()

    def check_in(self) -> None:
        """Note that this session has a page open: a turn that was accepted in it goes on if another one ends."""
        self.begin(self._check_in())

    async def _check_in(self) -> None:
        with contextlib.suppress(Error):
            await self.orm(note_open_session, self.role.person, session_key(self.scope), SYSTEM.now())

    async def refuse(self, error: NotUnderstood) -> None:
        """Answer a request that was not understood."""
        await self._answer(error.to, "", str(error))

    async def _answer(self, to: str, robot: str, wrong: str) -> None:
        await self.send(json.dumps({"t": "answer", "to": to, "robot": robot, "ok": not wrong, "text": wrong}))

    def _present(self) -> None:
        note_waiting(current_user(self.scope), SYSTEM.now())

    def _act(self, message: Do) -> str:
        user = current_user(self.scope)
        if not user.is_authenticated:
            return "Sign in first."
        return act(user, message.what, message.robot, message.ticket, SYSTEM.now(), session_key(self.scope))

    def _look(self) -> tuple[dict[str, Any], frozenset[int]] | None:
        user = current_user(self.scope)
        if not user.is_authenticated:
            return None
        now = SYSTEM.now()
        found = standings(user, now)
        return places(found, now), frozenset(one.queue for one in found)

    async def _serve(self, subscriber: Subscriber) -> None:
        """Send the person's places whenever they changed, and at certain moments."""
        while True:
            subscriber.begin_reading()
            try:
                seen = await self.orm(self._look)
            except Error:
                await asyncio.sleep(UNLINKED_S)
                continue
            if seen is None:
                await self.close(SIGNED_OUT)
                return
            shown, queues = seen
            subscriber.end_reading(queues)
            states = {one["state"] for one in shown["places"]}
            self.role = Role(self.role.person, queued=bool(states - {"missed", "ended"}))
            self._waits = bool(states & {"waiting", "offered"})
            await self.send(json.dumps(shown))
            await asyncio.sleep(LEAST_S)
            await self._pause(subscriber, shown)

    async def _pause(self, subscriber: Subscriber, shown: dict[str, Any]) -> None:
        """Wait for a change or for the next moment; a person without a place gets a pulse meanwhile."""
        while True:
            seconds = next_look_s(shown, SYSTEM.now().timestamp() * 1000)
            if not self.shared.people.link:
                seconds = min(seconds, UNLINKED_S if self.role.queued else PULSE_S)
            try:
                async with asyncio.timeout(seconds):
                    await subscriber.changed.wait()
                return
            except TimeoutError:
                if self.role.queued or not self.shared.people.link:
                    return
            await self.send(json.dumps({"t": "pulse", "now_ms": int(SYSTEM.now().timestamp() * 1000)}))


def next_look_s(content: dict[str, Any], now_ms: float) -> float:
    """Return how long the page waits for a message (s): until the next pulse, or the next moment before an end."""
    ends = [end for one in content["places"] for end in (one["kept_until_ms"] or one["until_ms"], one["idle_ms"])]
    moments: list[float] = [(end - now_ms) / 1000 - before for end in ends if end for before in MOMENTS_S]
    return min([PULSE_S, *(m + 0.05 for m in moments if m > 0)])
