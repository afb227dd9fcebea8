"""The presence of a robot page's person: noted while the page reports, and given up when it or its session ends."""

import asyncio
import contextlib
from datetime import timedelta

from portal.live.access import Access
from portal.live.people import current_user, session_key
from portal.live.sessions import SESSIONS, Ending
from portal.live.socket import Socket
from portal.live.threads import URGENT
from queueing import services as queue
from queueing.services import Place, end_session, last_report_elsewhere, mark_disconnected
from robots import bus
from robots.kit.clock import SYSTEM
from robots.models import Robot

LATELY = timedelta(seconds=6)  # an operator's page reports every two seconds
OTHERS_S = 0.6  # for other sessions of a person who has signed out to report that they continue


class Presence:
    """The presence of one socket's person at one robot."""

    def __init__(self, socket: Socket, slug: str, access: Access) -> None:
        self._socket, self._slug, self._access = socket, slug, access
        self._noting = self._unseen = False
        self._reported_at = SYSTEM.now()
        self._lock = SYSTEM.lock()  # a write that a thread has begun cannot be cancelled

    def note(self) -> None:
        """Note in the database that the person is present; beside requests, which must not wait for it."""
        self._unseen, self._reported_at = True, SYSTEM.now()
        if not self._noting:
            self._noting = True
            self._socket.begin(self._note())

    async def _note(self) -> None:
        try:
            while self._unseen:  # a note that has begun may be older than what asked for the next one
                self._unseen = False
                with contextlib.suppress(Exception):  # the next ping notes the presence again
                    await self._socket.orm(self.mark_seen)
        finally:
            self._noting = False

    def mark_seen(self) -> None:
        """Write that the person was present when the page reported; runs in a thread."""
        with self._lock:
            user = current_user(self._socket.scope)
            if user.is_authenticated and not self._socket.closed:
                robot, session = Robot.objects.get(slug=self._slug), session_key(self._socket.scope)
                queue.note_presence(robot, user, self._reported_at, classic=False, session=session)

    async def leave(self) -> None:
        """Note that the page is gone; the operator's turn is kept for a while."""
        if self._socket.role.person:
            await self._socket.orm(self.mark_left)

    def mark_left(self) -> None:
        """Write that the page is gone, unless it goes on over another socket; runs in a thread."""
        with self._lock:
            user = current_user(self._socket.scope)
            if user.is_authenticated and not self._access.continues_elsewhere(user.pk):
                robot, session = Robot.objects.get(slug=self._slug), session_key(self._socket.scope)
                queue.note_disconnection(robot, user, SYSTEM.now(), session, self._socket.lost_by)

    async def give_up(self, person: int, ending: Ending) -> None:
        """End the turn, as the ending says, unless another session of the person continues it."""
        if ending.place is Place.OTHERS:
            key, now = session_key(self._socket.scope), SYSTEM.now()
            reported = await SESSIONS.orm(last_report_elsewhere)(self._slug, person, key, now)
            if reported is not None and now - reported < LATELY:
                return
            await SESSIONS.orm(self._mark_gone)(person)
            if reported is not None:  # a page in the background reports seldom
                self._socket.shared.sessions.check_soon(person)
                await URGENT.run(bus.send_session_changed, person)
                await asyncio.sleep(OTHERS_S)
                reported = await SESSIONS.orm(last_report_elsewhere)(self._slug, person, key, now)
                if reported is not None and reported >= now:
                    return
        await SESSIONS.orm(end_session)(self._slug, person, ending.place, ending.reason, SYSTEM.now())

    def _mark_gone(self, person: int) -> None:
        with self._lock:  # after a note of presence that has begun; none begins any more
            mark_disconnected(self._slug, person, SYSTEM.now())
