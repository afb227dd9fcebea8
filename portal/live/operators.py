"""The operator's stream: the robot's socket again, apart from everybody's, opened with a one-time code.

It carries all that the public one does, and commands, Stop and presence. It ends with the grant that it was opened
for; the page goes on over the public one.
"""

from typing import Any

from django.db import Error

from portal.live import codes
from portal.live.consumers import RobotConsumer
from portal.live.people import current_user
from portal.live.sessions import Ending, SignIn
from portal.live.threads import DRIVERS, Pool
from queueing.services import Place
from robots.kit.clock import SYSTEM
from robots.models import Grant

PROTOCOL = "farhand.operator"  # offered by the page, with the code behind it
OVER = 4410
TURN_OVER = Ending(OVER, codes.TURN_OVER, "", Place.KEPT)
CODES = Pool("codes", 2)  # whoever tries codes keeps nobody else waiting


class OperatorConsumer(RobotConsumer):
    """One page of the person who drives."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._opened_for = 0  # the grant
        self._goes_on = True

    def subprotocol(self) -> str | None:
        """Return the name that goes before the code."""
        return PROTOCOL if PROTOCOL in self.scope.get("subprotocols", ()) else None

    async def opened(self) -> None:
        """Spend the code; whoever has no valid one is told why and goes."""
        self.slug = self.scope["url_route"]["kwargs"]["slug"]
        offered = [one for one in self.scope.get("subprotocols", ()) if one != PROTOCOL]
        try:
            self._opened_for = await CODES.orm(self._use)(offered[0] if offered else "")
        except codes.CodeRefused as refused:
            await self.close(OVER, str(refused))
            return
        except Error:
            await self.close(OVER, codes.UNKNOWN)
            return
        await super().opened()

    def _enters(self) -> bool:
        """Return True: whoever drives can always open the stream; codes and the address are limited."""
        return True

    def pool(self) -> Pool:
        """Return the threads of those who drive."""
        return DRIVERS

    def _use(self, code: str) -> int:
        return codes.use(code, self.slug, current_user(self.scope), SYSTEM.now())

    def goes_on_elsewhere(self, person: int) -> bool:
        """Return False: an operator whose stream ends is away."""
        return False

    def alone(self) -> bool:
        """Return True: it is the stream of one person."""
        return True

    def _snapshot(self, link: bool, public: str = "") -> tuple[str, SignIn | None]:
        shown, sign_in = super()._snapshot(link, public)
        # whose session has ended is dealt with by the check of sessions
        self._goes_on = self.holds == self._opened_for or self.nobody
        return shown, sign_in

    async def send_snapshot(self) -> None:
        """Send everything; if the turn is over, that is the last that comes."""
        await super().send_snapshot()
        if not self._goes_on and not self.over:
            await self.shut(TURN_OVER)

    def judge(self, user: Any) -> Ending | None:
        """Return also whether the turn is over; so it ends though nobody was told of it."""
        ending = super().judge(user)
        if ending is None and not Grant.objects.filter(pk=self._opened_for, ended_at=None).exists():
            return TURN_OVER
        return ending
