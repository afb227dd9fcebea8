"""Sends one viewer the snapshot of a robot: at the beginning, and again when the last one is out of date."""

import asyncio
import json

from django.db import Error

from portal.live.access import Access
from portal.live.people import Role, current_user
from portal.live.sessions import SignIn, sign_in_of
from portal.live.shared import with_person
from portal.live.snapshot import cheered_grant, of_person, snapshot
from portal.live.socket import Socket
from portal.live.viewer import Viewer
from portal.live.writer import Writer
from portal.stores import down_text
from robots.kit.clock import SYSTEM
from robots.models import Robot

LEAST_S = 0.5  # between two snapshots for a person who is signed in and does not drive, however often something changes
AGAIN_S = 2.0  # between two attempts while the database is away
NOT_FOUND = 4404


class SnapshotSender:
    """Sends the snapshots of one socket; `outdated` asks for one. Changes while one is read or sent are in the next."""

    def __init__(self, socket: Socket, viewer: Viewer, access: Access, writer: Writer, outdated: asyncio.Event) -> None:
        self._socket, self._viewer, self._access, self._writer = socket, viewer, access, writer
        self._slug, self._outdated = viewer.slug, outdated
        self._hub, self._shared = socket.shared.hub, socket.shared.snapshots
        self._retrying = False
        self._cheers = 0  # the grant in which one may cheer, by the newest snapshot

    async def run(self) -> None:
        """Send a new snapshot when the last one is out of date; pictures and states do not wait for it."""
        while True:
            await self._outdated.wait()
            await self._writer.wait_until_told()
            await self._writer.wait_until_free()  # on a slow line one snapshot has all changes meanwhile
            self._outdated.clear()
            await self.send()
            if not (self._socket.role.grant or self._socket.stranger):  # strangers share one
                await asyncio.sleep(LEAST_S)

    async def send(self) -> None:
        """Send everything, and note the person's role."""
        try:
            if self._socket.stranger:
                shared = await self._shared.ask(self._slug, lambda: self._hub.link)
                self._hub.cheers(self._slug).follow(shared.cheers)
                await self._writer.tell("snapshot", shared.of_strangers, shared=True)
                return
            public = ""
            if self._access.shares_snapshots(self._socket.role):
                shared = await self._shared.ask(self._slug, lambda: self._hub.link)
                public, self._cheers = shared.public, shared.cheers
            text, role, sign_in = await self._socket.orm(self.read, self._hub.link, public)
        except Error as error:
            await self.report_store_down(error)
            return
        except Robot.DoesNotExist:
            await self._socket.close(NOT_FOUND)
            return
        self._socket.role = role
        self._hub.cheers(self._slug).follow(self._cheers)
        self._socket.sign(sign_in)
        self._hub.count_as(self._viewer, 0 if role.grant else role.person)
        ending = self._access.ending(role)
        if ending is None:
            await self._writer.tell("snapshot", text)
            return
        await self._socket.send(text)
        if not self._socket.closed:
            await self._socket.shut(ending)

    def read(self, link: bool, public: str = "") -> tuple[str, Role, SignIn | None]:
        """Return the snapshot as JSON, the person's role, and who signed in; runs in a thread.

        `public`: the part that everybody sees, if it was asked for.
        """
        user, now = current_user(self._socket.scope), SYSTEM.now()
        me = of_person(self._slug, user, now) if public else None
        if me is None:
            whole = snapshot(self._slug, user, now, link)
            me, self._cheers = whole.pop("me"), cheered_grant(whole)
            public = json.dumps(whole)
        role = Role(
            user.pk or 0, not user.is_authenticated, me["grant"], bool(me.get("staff")), me["ticket"] is not None
        )
        return with_person(public, me), role, sign_in_of(self._socket.scope, user)

    async def report_store_down(self, error: Exception) -> None:
        """Tell the page that the database is away, and try again soon."""
        await self._socket.send(json.dumps({"t": "store", "text": down_text(error)}))
        if not self._retrying:
            self._retrying = True
            self._socket.begin(self._retry())

    async def _retry(self) -> None:
        await asyncio.sleep(AGAIN_S)
        self._retrying = False
        self._outdated.set()
