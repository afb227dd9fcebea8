"""The robot's socket: frames, states and events out; commands, stop and presence in.

What must not wait for the database does not: a stop and the keep-alives of a held motion go
to the bus at once, from what this socket was told last. Everything else is asked in order.
"""

import asyncio
import contextlib
import json
import logging
from collections.abc import Callable
from typing import Any

import msgspec
from django.db import Error

from accounts.services import cleared
from portal.live.actions import Answer, act, plan
from portal.live.hub import Viewer, hub
from portal.live.line import Line
from portal.live.messages import ROBOT, Command, Keep, LetGo, NotUnderstood, Ping, Plan, RobotMessage, Stop, Watch
from portal.live.people import current_user
from portal.live.sessions import NOT_STAFF, SESSIONS, UNCLEARED, Badge, Ending, badge_of, doorman
from portal.live.snapshot import snapshot
from portal.live.threads import ANYBODY, KNOWN, URGENT
from portal.stores import down_text
from queueing import services as queue
from queueing.sessions import Place, disconnect, session_over
from robots import bus
from robots.clock import SYSTEM
from robots.messages import Changed
from robots.models import Robot

log = logging.getLogger(__name__)
RESYNC_S = 1.0
AGAIN_S = 2.0  # between two looks at a database that is away
PLAN_S = 0.05  # between two previews of one page
NOT_FOUND = 4404
WAITING = 64
OTHERS_S = 0.6  # for other sessions of a person who has signed out to say that they go on
OUR_FAULT = "The portal failed at this request and has written down why; staff can find it in the log."


class RobotConsumer(Line):
    """One viewer of one robot; whoever holds the grant may also command it."""

    wire = ROBOT

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._asked: asyncio.Queue[tuple[RobotMessage, bool]] = asyncio.Queue(WAITING)
        self._stale = asyncio.Event()
        self._plan: Plan | None = None
        self._planning = asyncio.Event()
        self.viewer: Viewer | None = None
        self._me, self._jog = 0, 0
        self._known, self._placed, self._operating, self._may_stop = False, False, False, False
        self._grant = 0  # that this person operates under, as the snapshot said last; staff need none
        self._held: frozenset[str] | None = None
        self._looking = False

    async def opened(self) -> None:
        """Send the snapshot, begin to forward."""
        self.slug = self.scope["url_route"]["kwargs"]["slug"]
        try:
            self._held = await self._orm(self._held_kinds)
        except Robot.DoesNotExist:
            await self.close(NOT_FOUND)
            return
        except Error as error:
            await self._store_down(error)
        viewer = self.viewer = Viewer(self.slug)
        hub().attach(viewer)
        self._asked.put_nowait((Ping(), False))
        await self._send_snapshot()
        for loop in (self._forward, self._serve, self._resync, self._preview):
            self.begin(loop(viewer))

    async def left(self) -> None:
        """Forget the viewer; the operator's turn is kept for a while."""
        if self.viewer is None:
            return
        hub().detach(self.viewer)
        if self._jog:
            await self._keep(self._jog, held=False)
        if self._me:
            await self._orm(self._mark_left)

    async def _orm(self, function: Callable[..., Any], *args: Any) -> Any:
        """Ask the database, in threads that this person has a right to."""
        return await (KNOWN if self._known else ANYBODY).orm(function, self._me)(*args)

    def judge(self, user: Any) -> Ending | None:
        """Return whether a clearance or a permission on which the socket hangs is gone; runs in a thread."""
        if self.viewer is not None and self.viewer.trace and not user.has_perm("robots.change_robot"):
            return NOT_STAFF
        if self._placed and not cleared(user, Robot.objects.get(slug=self.slug)):
            return UNCLEARED
        return None

    def check_in(self) -> None:
        """Tell the database soon that the person is here."""
        with contextlib.suppress(asyncio.QueueFull):
            self._asked.put_nowait((Ping(), False))

    async def shut(self, ending: Ending) -> None:
        """Close, and end the turn unless another session of the person goes on with it."""
        if self.viewer is not None:
            hub().detach(self.viewer)
        person = self.badge.user if self.badge else 0  # a later snapshot knows nobody any more
        await asyncio.gather(self.close(ending.code, ending.text), self._give_up(person, ending))

    async def _give_up(self, person: int, ending: Ending) -> None:
        if ending.place is Place.OTHERS:
            await SESSIONS.orm(disconnect)(self.slug, person, SYSTEM.now())
            doorman().ring(person)
            await URGENT.run(bus.ring_session, person)
            await asyncio.sleep(OTHERS_S)
        await SESSIONS.orm(session_over)(self.slug, person, ending.place, ending.reason, SYSTEM.now())

    def _held_kinds(self) -> frozenset[str]:
        robot = Robot.objects.get(slug=self.slug)
        try:
            return frozenset(c.kind for c in robot.features().commands if c.held)
        except LookupError:  # its package is gone
            return frozenset()

    def _mark_left(self) -> None:
        user = current_user(self.scope)
        if user.is_authenticated:
            queue.disconnected(Robot.objects.get(slug=self.slug), user, SYSTEM.now())

    def _mark_seen(self) -> None:
        user = current_user(self.scope)
        if user.is_authenticated:
            queue.seen(Robot.objects.get(slug=self.slug), user, SYSTEM.now(), classic=False)

    async def take(self, message: RobotMessage) -> None:
        """Do at once what may not wait; queue the rest."""
        rung = False
        match message:
            case Ping():
                at_ms = int(SYSTEM.now().timestamp() * 1000)
                await self.send(json.dumps({"t": "pong", "n": message.n, "now_ms": at_ms, "link": hub().link}))
                if not self._me:
                    return
            case Stop() if self._may_stop:
                rung = await URGENT.run(bus.ring_stop, self.slug, self._grant)
            case Plan():
                self._plan = message  # the newest only: a slider asks faster than arms are planned
                self._planning.set()
                return
            case Watch():
                if self.viewer is not None:
                    hub().choose(self.viewer, frozenset(message.cameras))
                return
            case Keep() | LetGo():
                if message.seq == self._jog:
                    await self._keep(message.seq, held=isinstance(message, Keep))
                return
            case Command() if self._operating and (self._held is None or message.kind in self._held):
                self._jog = message.seq
        try:
            self._asked.put_nowait((message, rung))
        except asyncio.QueueFull:
            if not isinstance(message, Ping):
                await self._answer(message, Answer(False, "The database is too slow now; nothing was done.", "busy"))

    async def refuse(self, error: NotUnderstood) -> None:
        """Say what was wrong with a request."""
        await self._tell(error.to, error.seq, Answer(False, str(error), "bad_request"))

    async def _keep(self, seq: int, held: bool) -> None:
        await URGENT.run(bus.keep, self.slug, self._me, seq, held)
        if not held:
            self._jog = 0

    async def _serve(self, viewer: Viewer) -> None:
        """Carry out what was asked, in order."""
        while True:
            message, rung = await self._asked.get()
            if isinstance(message, Ping):
                with contextlib.suppress(Exception):  # presence is told again with the next ping
                    await self._orm(self._mark_seen)
                continue
            try:
                answer = await self._orm(act, self.scope, self.slug, message, rung)
            except Error as error:
                answer = Answer(False, down_text(error), "store_down")
            except Exception:
                log.exception("a request failed")
                answer = Answer(False, OUR_FAULT, "error")
            if answer.trace is not None:
                viewer.trace = answer.trace
            await self._answer(message, answer)

    async def _preview(self, viewer: Viewer) -> None:
        """Say where the newest target that was asked about would lead."""
        while True:
            await self._planning.wait()
            self._planning.clear()
            message, self._plan = self._plan, None
            if message is None:
                continue
            try:
                found = await self._orm(plan, self.scope, self.slug, message)
            except Error as error:
                found = {"ok": False, "text": down_text(error)}
            except Exception:
                log.exception("a preview failed")
                found = {"ok": False, "text": OUR_FAULT}
            await self.send(json.dumps({"t": "plan", "n": message.n, **found}))
            await asyncio.sleep(PLAN_S)

    async def _answer(self, message: RobotMessage, answer: Answer) -> None:
        seq = message.seq if isinstance(message, Command) else 0
        await self._tell(str(message.__struct_config__.tag), seq, answer)
        if answer.changed:
            await self._send_snapshot()

    async def _tell(self, to: str, seq: int, answer: Answer) -> None:
        await self.send(json.dumps({"t": "answer", "to": to, "seq": seq or None, **answer.fields()}))

    async def _send_snapshot(self) -> None:
        try:
            shown, badge = await self._orm(self._snapshot)
        except Error as error:
            await self._store_down(error)
            return
        except Robot.DoesNotExist:
            await self.close(NOT_FOUND)
            return
        self.sign(badge)
        await self.send(json.dumps(shown))

    async def _store_down(self, error: Exception) -> None:
        """Say that the database is away, and look again soon."""
        await self.send(json.dumps({"t": "store", "text": down_text(error)}))
        if not self._looking:
            self._looking = True
            self.begin(self._look_again())

    async def _look_again(self) -> None:
        await asyncio.sleep(AGAIN_S)
        self._looking = False
        self._stale.set()

    def _snapshot(self) -> tuple[dict[str, Any], Badge | None]:
        user = current_user(self.scope)
        shown = snapshot(self.slug, user, SYSTEM.now(), self.viewer.link if self.viewer else False)
        me = shown["me"]
        self._me, self._operating = user.pk or 0, bool(me["operating"])
        staff, turn = bool(me.get("staff")), shown["turn"]
        self._grant = turn["grant"] if turn and self._operating and not staff else 0
        self._may_stop = staff or self._grant > 0  # an operator's stop names the grant, however old this knowledge is
        self._placed = me["ticket"] is not None
        self._known = self._may_stop or self._operating or self._placed
        return shown, badge_of(self.scope, user)

    async def _forward(self, viewer: Viewer) -> None:
        """Send what the hub brings; without the link, read the database every second."""
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(RESYNC_S if not hub().link else 15.0):  # wait_for may swallow a cancellation
                    await viewer.wake.wait()
            viewer.wake.clear()
            viewer.link = hub().link
            if viewer.state is not None:
                state, viewer.state = viewer.state, None
                await self.send(bytes_data=state)
            resync = viewer.resync or not viewer.link
            viewer.resync = False
            while viewer.events:
                event = viewer.events.popleft()
                if isinstance(event, Changed):
                    resync = True
                else:
                    await self.send(msgspec.json.encode(event).decode())
            while viewer.frames:
                _, frame = viewer.frames.popitem()
                await self.send(bytes_data=frame)
            if resync:
                self._stale.set()

    async def _resync(self, viewer: Viewer) -> None:
        """Read everything again when it is stale; pictures and states do not wait for it."""
        while True:
            await self._stale.wait()
            self._stale.clear()
            await self._send_snapshot()
