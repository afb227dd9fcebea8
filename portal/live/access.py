"""The admission of sockets at a robot: everybody while there is room, and the operator with a one-time code.

An access has the rules in which everybody's socket and the operator's stream differ; each socket has one.
"""

from contextlib import ExitStack
from functools import cache
from typing import Any

from django.conf import settings
from django.db import Error

from portal.edge.dropped import drop
from portal.edge.limits import AddressCount
from portal.live import codes
from portal.live.hub import Hub
from portal.live.people import Role, current_user
from portal.live.sessions import Ending
from portal.live.threads import DRIVERS, Pool
from queueing.services import Place
from robots.kit.clock import SYSTEM
from robots.models import Grant

FULL, OVER = 4503, 4410
FULL_TEXT = "As many people watch this robot as the portal can serve. This page tries again."
ENOUGH_TEXT = "You watch robots in as many pages as one account may. Close one of them."
PROTOCOL = "farhand.operator"  # offered by the operator's page, with the code behind it
TURN_OVER = Ending(OVER, codes.TURN_OVER, "", Place.KEPT)
CODES = Pool("codes", 2)  # so that attempts with wrong codes delay nobody else


@cache
def accounts() -> AddressCount:
    """Return this process's counter of the sockets of each account."""
    return AddressCount(settings.LIMITS["SOCKETS_OF_ACCOUNT"])


class AccessRefused(Exception):
    """The socket is closed with this code; the text says why."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


class Access:
    """Access to everybody's socket, without a code."""

    protocol: str | None = None  # the WebSocket subprotocol that is spoken; None: it has none
    pool: Pool | None = None  # the threads for its queries; None: those for the person's role

    def __init__(self, slug: str, scope: dict[str, Any], hub: Hub) -> None:
        self._slug, self._scope, self._hub = slug, scope, hub

    async def admit(self) -> None:
        """Check whether the socket may be opened. Raises AccessRefused."""

    def enter(self, person: int, stranger: bool, leave: ExitStack) -> None:
        """Take a place among strangers or of the account; `leave` gives it back. Raises AccessRefused."""
        if stranger and self._hub.strangers(self._slug) >= settings.LIMITS["VIEWERS"]:
            drop("found the robot's places taken")
            raise AccessRefused(FULL, FULL_TEXT)
        if not person:
            return
        account = str(person)
        if not accounts().enter(account):
            drop("of an account that has enough")
            raise AccessRefused(FULL, ENOUGH_TEXT)
        leave.callback(accounts().leave, account)

    def shares_snapshots(self, role: Role) -> bool:
        """Return whether the public part of snapshots is read for many at once; an operator waits for nobody."""
        return not role.grant

    def ending(self, role: Role) -> Ending | None:
        """Return why the socket ends after the snapshot that was sent for this role; None if it goes on."""
        return None

    def judge(self) -> Ending | None:
        """Return why the socket has to end though no message said so; runs in a thread."""
        return None

    def continues_elsewhere(self, person: int) -> bool:
        """Return whether the page of a socket that ends goes on over the operator's stream; runs in a thread."""
        return codes.lately_opened(self._slug, person)


class OperatorAccess(Access):
    """Access to the operator's stream, which is opened with a one-time code and ends with the grant.

    The operator can always open it: it takes no place, only codes and the sockets of a network address are limited.
    After its end the page goes on without it.
    """

    protocol: str | None = PROTOCOL
    pool: Pool | None = DRIVERS

    _grant = 0  # the key of the grant for which it was opened

    async def admit(self) -> None:
        """Spend the code. Raises AccessRefused."""
        offered = [one for one in self._scope.get("subprotocols", ()) if one != PROTOCOL]
        try:
            self._grant = await CODES.orm(self._use)(offered[0] if offered else "")
        except codes.CodeRefused as refused:
            raise AccessRefused(OVER, str(refused)) from refused
        except Error as error:
            raise AccessRefused(OVER, codes.UNKNOWN) from error

    def _use(self, code: str) -> int:
        return codes.use(code, self._slug, current_user(self._scope), SYSTEM.now())

    def enter(self, person: int, stranger: bool, leave: ExitStack) -> None:
        """Take no place: the code was the admission."""

    def shares_snapshots(self, role: Role) -> bool:
        """Return False."""
        return False

    def ending(self, role: Role) -> Ending | None:
        """Return `TURN_OVER` if the person has the grant no more; the check of sessions deals with an ended session."""
        return None if role.grant == self._grant or role.anonymous else TURN_OVER

    def judge(self) -> Ending | None:
        """Return `TURN_OVER` if the grant has ended; so the stream ends though no message said so."""
        return None if Grant.objects.filter(pk=self._grant, ended_at=None).exists() else TURN_OVER

    def continues_elsewhere(self, person: int) -> bool:
        """Return False: an operator whose stream ends is away."""
        return False
