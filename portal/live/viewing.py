"""Watching a robot over a socket: pictures, states and events, and a new snapshot when the last one is out of date."""

import asyncio
import contextlib
import json
from datetime import timedelta
from typing import Any

import msgspec
from django.db import Error

from accounts.services import cleared
from portal.edge.direct import binary_frame, connection_of
from portal.live.audience import Seat, audience
from portal.live.hub import hub
from portal.live.line import Line
from portal.live.messages import Watch
from portal.live.people import current_user, session_key
from portal.live.rooms import Cameras, Viewer
from portal.live.sessions import NOT_STAFF, SESSIONS, UNCLEARED, Ending, SignIn, session_watch, sign_in_of
from portal.live.shared import snapshots, with_person
from portal.live.snapshot import of_person, snapshot
from portal.live.threads import URGENT
from portal.live.watchers import watchers_text
from portal.stores import down_text
from queueing.services import Place, end_session, last_report_elsewhere, mark_disconnected
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.packets import Changed
from robots.models import Robot

RESYNC_S = 1.0
LEAST_S = 0.5  # between two snapshots for a person who is signed in and does not drive, however often something changes
IDLE_S = 15.0  # a mailbox in which nothing waits is looked into all the same
AGAIN_S = 2.0  # between two attempts while the database is away
NOT_FOUND = 4404
LATELY = timedelta(seconds=6)  # an operator's page reports every two seconds
OTHERS_S = 0.6  # for other sessions of a person who has signed out to report that they continue


class Viewing(Line):
    """A socket at one robot: who watches, and what they may do."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.slug = ""
        self.viewer: Viewer | None = None
        self.grant = 0  # the grant of this person in the last snapshot; staff need none
        self.holds = 0  # the same, of staff too
        self.placed, self.operating, self.may_stop = False, False, False
        self._stale = asyncio.Event()
        self._looking = self.nobody = False
        self._freed = asyncio.Event()  # set whenever the connection has taken everything
        self._one_by_one = asyncio.Lock()
        self._noting = SYSTEM.lock()  # presence; what a thread has begun cannot be cancelled
        self._seat, self._leave = Seat(), contextlib.ExitStack()

    async def view(self, wish: Watch | None = None, cameras: Cameras | None = None) -> Viewer:
        """Start to watch: the snapshot first, then everything that comes, as far as it is wanted.

        `cameras`: those of the robot, if that was read.
        """
        viewer = self.viewer = Viewer(self.slug, connection_of(self.scope))
        viewer.stranger = self.stranger()
        if wish is not None:
            viewer.wish(wish)
        self._leave.callback(hub().detach, viewer)
        hub().attach(viewer, cameras)
        viewer.seat = self._seat = self._leave.enter_context(audience().one(self.slug))
        if viewer.connection is not None:
            self._leave.callback(viewer.connection.when_free, None)
            viewer.connection.when_free(self._freed.set)
        heard = await hub().heard(self.slug)  # or what changes between snapshot and subscription would be missed
        await self.send_snapshot()
        if not heard:
            self.begin(self._again_when_heard())
        viewer.counted = True
        self.begin(self._forward(viewer))
        self.begin(self._resync())
        return viewer

    async def _again_when_heard(self) -> None:
        await hub().heard(self.slug, None)
        self._stale.set()

    async def send(self, text_data: str | None = None, bytes_data: bytes | None = None, close: bool = False) -> None:
        """Send, and count the bytes."""
        self._seat.sent_bytes += len(bytes_data if bytes_data is not None else text_data or "")
        await super().send(text_data, bytes_data, close)

    async def left(self) -> None:
        """Watch no more."""
        self._leave.close()

    def judge(self, user: Any) -> Ending | None:
        """Return whether a clearance or permission that the socket needs was withdrawn; runs in a thread."""
        if self.viewer is not None and self.viewer.trace and not user.has_perm("robots.change_robot"):
            return NOT_STAFF
        if self.placed and not cleared(user, Robot.objects.get(slug=self.slug)):
            return UNCLEARED
        return None

    async def shut(self, ending: Ending) -> None:
        """Close, and end the turn unless another session of the person continues it."""
        if self.viewer is not None:
            hub().detach(self.viewer)
        person = self.sign_in.user if self.sign_in else 0  # a later snapshot has no person any more
        await asyncio.gather(self.close(ending.code, ending.text), self._give_up(person, ending))

    async def _give_up(self, person: int, ending: Ending) -> None:
        if ending.place is Place.OTHERS:
            key, now = session_key(self.scope), SYSTEM.now()
            reported = await SESSIONS.orm(last_report_elsewhere)(self.slug, person, key, now)
            if reported is not None and now - reported < LATELY:
                return
            await SESSIONS.orm(self._mark_gone)(person)
            if reported is not None:  # a page in the background reports seldom
                session_watch().check_soon(person)
                await URGENT.run(bus.send_session_changed, person)
                await asyncio.sleep(OTHERS_S)
                reported = await SESSIONS.orm(last_report_elsewhere)(self.slug, person, key, now)
                if reported is not None and reported >= now:
                    return
        await SESSIONS.orm(end_session)(self.slug, person, ending.place, ending.reason, SYSTEM.now())

    def _mark_gone(self, person: int) -> None:
        with self._noting:  # after a note of presence that has begun; none begins any more
            mark_disconnected(self.slug, person, SYSTEM.now())

    async def send_snapshot(self) -> None:
        """Send everything, and remember what this person may do."""
        try:
            if self.stranger():
                await self._tell_text((await snapshots().ask(self.slug, lambda: hub().link)).of_strangers)
                return
            public = "" if self.alone() else (await snapshots().ask(self.slug, lambda: hub().link)).public
            shown, sign_in = await self.orm(self._snapshot, hub().link, public)
        except Error as error:
            await self.store_down(error)
            return
        except Robot.DoesNotExist:
            await self.close(NOT_FOUND)
            return
        self.sign(sign_in)
        if self.viewer is not None:
            hub().seat(self.viewer, self.me, self.operating)
        await self.send(shown)

    def stranger(self) -> bool:
        """Return whether nobody is signed in, and nobody will be: a sign-in makes a new session."""
        return self.nobody or not session_key(self.scope)

    async def store_down(self, error: Exception) -> None:
        """Tell the page that the database is away, and try again soon."""
        await self.send(json.dumps({"t": "store", "text": down_text(error)}))
        if not self._looking:
            self._looking = True
            self.begin(self._look_again())

    async def _look_again(self) -> None:
        await asyncio.sleep(AGAIN_S)
        self._looking = False
        self._stale.set()

    def alone(self) -> bool:
        """Return whether this socket's snapshots wait for nobody else's: the person drives."""
        return self.operating

    def _snapshot(self, link: bool, public: str = "") -> tuple[str, SignIn | None]:
        """Return the snapshot as JSON, and who signed in; `public`: that of everybody, if it was asked for."""
        user, now = current_user(self.scope), SYSTEM.now()
        me = of_person(self.slug, user, now) if public else None
        if me is None:
            shown = snapshot(self.slug, user, now, link)
            me = shown.pop("me")
            public = json.dumps(shown)
        self.me, self.operating, self.holds = user.pk or 0, bool(me["can"]["drive"]), me["grant"]
        self.nobody = not user.is_authenticated
        staff = bool(me.get("staff"))
        self.grant = 0 if staff else self.holds
        self.may_stop = staff or self.grant > 0  # an operator's stop names the grant, even if this is out of date
        self.placed = me["ticket"] is not None
        self.known = self.may_stop or self.operating or self.placed
        return with_person(public, me), sign_in_of(self.scope, user)

    async def _forward(self, viewer: Viewer) -> None:
        """Send what waits in the mailbox; while Redis is away, read the database every second."""
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(RESYNC_S if not hub().link else IDLE_S):  # wait_for may lose a cancellation
                    await viewer.wake.wait()
            if not hub().link:
                self._stale.set()
            await self._empty(viewer)

    async def _empty(self, viewer: Viewer) -> None:
        """Send everything in the mailbox, the newest of each kind; pictures of several cameras in turns."""
        sent = True
        while sent or viewer.wake.is_set():
            viewer.wake.clear()  # first, for something may come while this waits
            await self._free()
            sent = False
            if viewer.resync:
                viewer.resync = False
                self._stale.set()
            if viewer.state is not None:
                state, viewer.state, sent = viewer.state, None, True
                await self._tell_bytes(state)
            for sound in viewer.take_sounds():
                sent = True
                await self._tell_bytes(sound)
            for packet in hub().streams.news(self.slug, viewer.told):
                sent = True
                await self._tell_bytes(packet)
            while viewer.events:
                event, sent = viewer.events.popleft(), True
                if isinstance(event, Changed):
                    self._stale.set()
                else:
                    await self._tell_text(msgspec.json.encode(event).decode())
            if viewer.counted:
                viewer.counted, sent = False, True
                await self._tell_text(watchers_text(hub().watchers(self.slug)))
            await self._free()
            if packets := hub().video(viewer):
                sent = True
                await self._tell_together(packets)
            if viewer.frames:
                frame, sent = viewer.frames.pop(next(iter(viewer.frames))), True
                await self._tell_bytes(frame)
        viewer.emptied()

    async def _free(self) -> None:
        """Wait until the connection has taken everything, or is gone; what comes meanwhile replaces what waits.

        Who asks first is first, so that on a slow line pictures do not keep snapshots waiting for ever.
        """
        connection = self.viewer.connection if self.viewer is not None else None
        if connection is None or (connection.free() and not self._one_by_one.locked()):
            return
        async with self._one_by_one:
            while not connection.free() and not connection.is_gone():
                self._freed.clear()
                await self._freed.wait()

    async def _tell_bytes(self, data: bytes) -> None:
        await self._free()
        if self.viewer is None or self.viewer.connection is None:
            await self.send(bytes_data=data)
        elif not self.viewer.connection.is_gone():
            self.viewer.write(binary_frame(data))

    async def _tell_together(self, packets: list[bytes]) -> None:
        """Send several messages, over a connection in one go: what comes meanwhile waits behind them."""
        if self.viewer is None or self.viewer.connection is None:
            for packet in packets:
                await self.send(bytes_data=packet)
        elif not self.viewer.connection.is_gone():
            self.viewer.write(b"".join(map(binary_frame, packets)))

    async def _tell_text(self, text: str) -> None:
        await self._free()
        if self.viewer is None or self.viewer.connection is None:
            await self.send(text)
        elif not self.viewer.connection.is_gone():
            self.viewer.write_text(text)

    async def _resync(self) -> None:
        """Send a new snapshot when the last one is out of date; pictures and states do not wait for it."""
        while True:
            await self._stale.wait()
            await self._free()  # on a slow line one snapshot tells all that changed meanwhile
            self._stale.clear()
            await self.send_snapshot()
            if not (self.operating or self.stranger()):  # of strangers' there is one for all
                await asyncio.sleep(LEAST_S)
