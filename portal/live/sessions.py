"""Checks whether the people behind open sockets are still signed in, active, cleared and staff.

The rows are read about once a second for all sockets of this process together; a message on the bus only makes it
sooner. So it works without Redis too, and in whichever process the person signs out.
"""

import asyncio
import contextlib
import logging
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Protocol

from django.contrib.auth import get_user_model
from django.contrib.sessions.models import Session
from django.db import Error

from portal.live.people import session_key
from portal.live.threads import Pool
from queueing.models import PlaceEnd
from queueing.services import Place
from robots.kit.clock import SYSTEM

log = logging.getLogger(__name__)
CHECK_S = 0.8
APART_S = 0.2  # between two checks, however many messages arrive
RAN_OUT_S = 5.0  # within this time sessions are moved along with a time of day that was set ahead
SESSIONS = Pool("sessions", 2)


@dataclass(frozen=True)
class SignIn:
    """The session, the person and a digest of the password with which a socket was opened."""

    key: str
    user: int
    proof: str


@dataclass(frozen=True)
class Ending:
    """The reason why a socket is closed: code, text for the page, and the consequence for place and turn."""

    code: int
    text: str
    reason: str
    place: Place


SIGNED_OUT = Ending(4401, "You have signed out.", "signed out", Place.OTHERS)
RAN_OUT = Ending(4401, "You were signed out: sign in again.", "the sign-in ran out", Place.OTHERS)
NEW_PASSWORD = Ending(4401, "The password was changed: sign in again.", "password changed", Place.TURN_ENDS)
SUSPENDED = Ending(4401, "This account is switched off.", PlaceEnd.SUSPENDED, Place.LOST)
UNCLEARED = Ending(4403, "Your clearance for this robot was withdrawn.", PlaceEnd.UNCLEARED, Place.LOST)
NOT_STAFF = Ending(4403, "The live trace is for staff.", "", Place.KEPT)


class Signed(Protocol):
    """A socket of a signed-in person."""

    sign_in: SignIn | None

    def judge(self, user: Any) -> Ending | None:
        """Return why the socket must end though its session may go on; runs in a thread."""

    def check_in(self) -> None:
        """Note soon in the database that the person is present."""

    async def shut(self, ending: Ending) -> None:
        """Close the socket and give up its place or turn, as the ending says."""


def sign_in_of(scope: dict[str, Any], user: Any) -> SignIn | None:
    """Return the sign-in of the person of a socket; None if nobody is signed in."""
    return SignIn(session_key(scope), user.pk, user.get_session_auth_hash()) if user.is_authenticated else None


def over(signed: Iterable[tuple[Signed, SignIn]], now: datetime) -> list[tuple[Signed, Ending]]:
    """Return the sockets that must end, with the reason: two queries for all, more for operators."""
    asked = list(signed)
    keys, ids = {sign_in.key for _, sign_in in asked}, {sign_in.user for _, sign_in in asked}
    until = dict(Session.objects.filter(session_key__in=keys).values_list("pk", "expire_date"))
    people = get_user_model()._default_manager.in_bulk(ids)
    found = []
    for socket, sign_in in asked:
        user = people.get(sign_in.user)
        ending: Ending | None
        if user is None or not user.is_active:
            ending = SUSPENDED
        elif user.get_session_auth_hash() != sign_in.proof:
            ending = NEW_PASSWORD
        elif sign_in.key not in until:
            ending = SIGNED_OUT
        else:
            ending = socket.judge(user) or (RAN_OUT if until[sign_in.key] <= now else None)
        if ending is not None:
            found.append((socket, ending))
    return found


class SessionWatch:
    """Checks the signed-in sockets of one event loop; does nothing while there are none."""

    def __init__(self, clock: Callable[[], float] = SYSTEM.awake) -> None:
        self._clock = clock
        self._signed: dict[Signed, None] = {}  # in the order in which they signed
        self._wake = asyncio.Event()
        self._task: asyncio.Task[None] | None = None
        self._ending: set[asyncio.Task[None]] = set()
        self._ran_out: dict[str, float] = {}  # since when a session is found to have run out (monotonic, s)

    def add(self, socket: Signed) -> None:
        """Check the session of a socket from now on."""
        self._signed[socket] = None
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._watch())

    def remove(self, socket: Signed) -> None:
        """Check a socket no more; one that is not known is no error."""
        self._signed.pop(socket, None)

    def check_soon(self, person: int) -> None:
        """Check now, because the session, password, account or clearance of that person may have changed."""
        self._wake.set()
        for socket in self._signed:
            if socket.sign_in is not None and socket.sign_in.user == person:
                socket.check_in()

    def _lasting(self, ended: list[tuple[Signed, Ending]]) -> list[tuple[Signed, Ending]]:
        """Return the endings without sessions that ran out just now: the time of day may have been set a moment ago."""
        now = self._clock()
        keys = {socket.sign_in.key for socket, ending in ended if ending is RAN_OUT and socket.sign_in is not None}
        self._ran_out = {key: self._ran_out.get(key, now) for key in keys}
        lately = {key for key, since in self._ran_out.items() if now - since < RAN_OUT_S}
        return [
            (socket, ending) for socket, ending in ended
            if ending is not RAN_OUT or socket.sign_in is None or socket.sign_in.key not in lately
        ]  # fmt: skip

    async def _watch(self) -> None:
        while self._signed:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(CHECK_S):
                    await self._wake.wait()
            self._wake.clear()
            signed = [(s, s.sign_in) for s in self._signed if s.sign_in is not None]
            try:
                ended = await SESSIONS.orm(over)(signed, SYSTEM.now())
            except Error as error:  # nobody can do anything meanwhile either
                log.debug("sessions cannot be checked now: %s", error)
                ended = []
            except Exception:
                log.exception("sessions cannot be checked")
                ended = []
            for socket, ending in self._lasting(ended):
                self.remove(socket)
                task = asyncio.create_task(socket.shut(ending))  # a peer that does not read must not delay the others
                self._ending.add(task)
                task.add_done_callback(self._ending.discard)
            await asyncio.sleep(APART_S)
