"""The recorder of this host: a process of its own that listens on the bus as a viewer does.

No owner waits for it or knows of it. It finds open grants of turns and jobs in the database, writes one file for each,
and says in the database how it ended. Nothing is loaded and nothing but events is heard while nothing is recorded.
"""

import logging
import socket
from collections.abc import Callable, Iterable
from datetime import timedelta
from math import inf
from typing import TYPE_CHECKING

import msgspec
import redis
from django.conf import settings
from django.db import Error, close_old_connections, connection

from robots import bus
from robots.bus.streams import kept_stream
from robots.grants import stage_event
from robots.kit.clock import SYSTEM, Clock
from robots.kit.contract.streams import MOST
from robots.kit.description import views
from robots.kit.packets import Changed, CommandStage, Event, Notice, decode
from robots.models import Command, Grant, Recording, RecordingState
from robots.recordings import keeping, telling
from robots.states import COMMAND_FINAL
from workers.recorder.movies import MovieMaker

if TYPE_CHECKING:
    from workers.recorder.taping import Taping

log = logging.getLogger(__name__)
LOOK_S = 2.0  # between two looks at the database; an event of a robot makes it look at once
SOON_S = 0.1  # the least time between two looks
MARK_S = 1.5  # between two marks that pictures are wanted; a mark counts for four seconds
LISTEN_S = 0.25  # while something is recorded
NO_ROOM = "The server's disk had no room for it."
REST_S = 4.0  # that commands of an ended grant may take to end


class _Running:
    """One recording: its row, what writes it, and the commands whose arguments were told."""

    def __init__(self, row: Recording, grant: Grant, taping: "Taping", cameras: int) -> None:
        self.row, self.grant, self.taping, self.cameras = row, grant, taping, cameras
        self.slug = grant.robot.slug
        self.stages: dict[int, str] = {}  # the stage of each command that was told last
        self.over_at: float | None = None  # when its grant was found ended

    def channels(self) -> list[str]:
        """Return the channels beside the robot's events."""
        frames = [bus.frames_channel(self.slug, camera) for camera in range(self.cameras)]
        return [bus.state_channel(self.slug), bus.stream_channel(self.slug), *frames]


class Recorder:
    """Records every robot of this portal, one thread and one writer a recording."""

    def __init__(self, clock: Clock = SYSTEM, host: str = "") -> None:
        self._clock, self._host = clock, host or socket.gethostname()
        self.running: dict[int, _Running] = {}  # by grant
        self._ending: list[_Running] = []
        self._refused: set[int] = set()  # grants that are not recorded
        self._reader: bus.Reader | None = None
        self._offset = timedelta(0)  # the database's time minus ours
        self._zero_ns = 0  # the database's time when the monotonic clock began, as found before a recording
        self._looked = self._marked = -1e9
        self._soon = self._left = True
        self._movies: MovieMaker | None = None

    def run(self, over: Callable[[], bool]) -> None:
        """Record until `over`; Redis or a database that is away is waited for."""
        while not over():
            try:
                self._listen(over)
            except (redis.RedisError, OSError) as error:
                log.debug("recorder: %s", error)
                self._clock.sleep(0.5)
            finally:
                self._hang_up()
            self._tell_all("gap", "The link to the robot was interrupted here.")
        self._end_all()

    def _listen(self, over: Callable[[], bool]) -> None:
        reader = self._reader = bus.Reader(self._clock)
        for one in self.running.values():
            self._hear(one.channels())
            self._before(one)  # what was not heard meanwhile
        self._looked = -1e9
        while not over():
            self._look_if_due()
            if not reader.channels:  # no robot is recorded
                self._clock.sleep(LOOK_S)
                continue
            busy = self.running or self._ending
            message = reader.read(SOON_S if self._soon else LISTEN_S if busy else LOOK_S)
            while message is not None:
                self._take(*message)
                message = reader.read(0) if self._clock.monotonic() < self._next else None

    @property
    def _next(self) -> float:
        """Return when the recorder has to look up from what it hears."""
        return min(self._looked + LOOK_S, self._marked + MARK_S) if self.running else self._looked + LOOK_S

    def _hang_up(self) -> None:
        if self._reader is not None:
            self._reader.close()
        self._reader = None

    def _hear(self, channels: Iterable[str]) -> None:
        if self._reader is not None:
            self._reader.subscribe(channels)

    def _look_if_due(self) -> None:
        now = self._clock.monotonic()
        if now - self._looked >= LOOK_S or (self._soon and now - self._looked >= SOON_S):
            self._looked, self._soon = now, False
            try:
                self._look()
            except Error as error:
                log.debug("recorder: %s", error)
                close_old_connections()
        if self.running and now - self._marked >= MARK_S:
            self._marked = now
            for one in self.running.values():
                self.ask(one)

    @staticmethod
    def ask(one: _Running) -> None:
        """Ask for pictures of its cameras, no more than it takes."""
        if one.taping.every_s < inf:
            for camera in range(one.cameras):
                bus.watch(one.slug, bus.demand_for(camera, max(bus.SOME_S, one.taping.every_s)).name)

    def _look(self) -> None:
        """Find out which grants are open, and begin and end recordings after them."""
        self._hear(bus.events_channel(slug) for slug in keeping.slugs_recorded())
        grants = {grant.pk: grant for grant in keeping.to_record()}
        self._refused &= grants.keys()
        for pk, one in list(self.running.items()):
            if one.taping.written.is_set() or (pk not in grants and self._rests(one)):
                self._end(self.running.pop(pk))
        for grant in grants.values():
            if grant.pk not in self.running and grant.pk not in self._refused:
                self._begin(grant)
        for one in [one for one in self._ending if one.taping.written.is_set()]:
            self._settle(one)
            self._ending.remove(one)
        self._movies = self._movies or MovieMaker(self._clock)
        self._movies.look()
        if self._left and not self.running and not self._ending:
            self._settle_left()
            self._left = False

    def now_ns(self) -> int:
        """Return the database's time, in ns since 1970; it goes on evenly while anything is recorded."""
        return self._zero_ns + int(self._clock.monotonic() * 1e9)

    def _measure_offset(self) -> None:
        if connection.vendor != "postgresql":
            return  # SQLite uses this host's clock
        before = self._clock.now()
        with connection.cursor() as cursor:
            cursor.execute("SELECT clock_timestamp()")
            (theirs,) = cursor.fetchone()
        self._offset = theirs - before - (self._clock.now() - before) / 2

    def _begin(self, grant: Grant) -> None:
        self._measure_offset()
        if not self.running:  # else a step of the time of day would be a gap, or the way back, in what is recorded
            now = self._clock.now() + self._offset
            self._zero_ns = int(now.timestamp() * 1e9) - int(self._clock.monotonic() * 1e9)
        row = keeping.begin(grant, self._host, self._clock.now() + self._offset)
        self._refused.add(grant.pk)  # once, whatever happens
        if row is None:
            return
        if not keeping.room():
            keeping.finish(row, RecordingState.CUT, NO_ROOM, row.began_at)
            return
        try:
            one = self._taped(row, grant)
        except (LookupError, ImportError, OSError) as error:  # the robot's package is gone
            keeping.finish(row, RecordingState.CUT, str(error), row.began_at)
            return
        self.running[grant.pk] = one
        self._marked = -1e9
        self._hear(one.channels())
        self._before(one)  # first: what a byte stream showed before is known from the first moment on
        for command in Command.objects.filter(grant=grant).select_related("grant__robot").order_by("id"):
            self._tell_command(one, stage_event(command), command)

    @staticmethod
    def _taped(row: Recording, grant: Grant) -> _Running:
        from workers.recorder.taping import Taping  # noqa: PLC0415 - loaded when the first recording begins

        robot = grant.robot
        spec, cameras = robot.spec(), len(views(robot.description()))
        units = {channel.name: channel.unit for channel in spec.packed()}
        told = {"robot": robot.slug, "driver": robot.driver, "kind": grant.kind, "began": row.began_at.isoformat()}
        told |= {"units": msgspec.json.encode(units).decode(), "joints": msgspec.json.encode(spec.joints).decode()}
        limit = settings.RECORDING["MB"] * keeping.MB
        taping = Taping(keeping.path_of(row), told, spec, cameras, limit, keeping.room)
        return _Running(row, grant, taping, cameras)

    def _rests(self, one: _Running) -> bool:
        """Tell what the bus did not of an ended grant's commands. Return whether all have ended, or took too long."""
        one.over_at = self._clock.monotonic() if one.over_at is None else one.over_at
        rows = list(Command.objects.filter(grant=one.grant).select_related("issued_by", "grant__robot").order_by("id"))
        for row in rows:
            if one.stages.get(row.pk) != row.state:
                self._tell_command(one, stage_event(row), row)
        return all(row.final for row in rows) or self._clock.monotonic() - one.over_at > REST_S

    def _before(self, one: _Running) -> None:
        """Take what the bus keeps of byte streams, all at one time, so that deltas have something to stand on."""
        at_ns = self.now_ns()
        for stream in range(MOST):
            kept = kept_stream(one.slug, stream)
            if kept is None:
                return
            for packet in kept:
                one.taping.stream(at_ns, packet)

    def _take(self, channel: str, data: bytes) -> None:
        _, slug, what = channel.split(":", 2)
        event = self._event(data) if what == "events" else None
        if isinstance(event, Changed | CommandStage):
            self._soon = True
        for one in self.running.values():
            if one.slug != slug:
                continue
            at_ns = self.now_ns()
            if what == "state":
                one.taping.state(at_ns, data)
            elif what == "stream":
                one.taping.stream(at_ns, data)
            elif what.startswith("frames"):
                one.taping.picture(int(what.removeprefix("frames") or 0), at_ns, data)
            elif isinstance(event, CommandStage) and event.grant == one.grant.pk:
                self._tell_command(one, event)
            elif isinstance(event, Notice):
                one.taping.tell("events", at_ns, _event("notice", event.text, event.level))

    @staticmethod
    def _event(data: bytes) -> Event | None:
        try:
            return decode(data)
        except msgspec.MsgspecError:
            return None

    def _tell_command(self, one: _Running, stage: CommandStage, row: Command | None = None) -> None:
        """Record a stage; the first of a command with its arguments, where the database answers."""
        if one.stages.get(stage.id) in COMMAND_FINAL:
            return  # told from its row, before what the bus says of it was taken
        told = msgspec.to_builtins(stage)
        known = stage.id in one.stages
        one.stages[stage.id] = stage.state
        if not known:
            try:
                row = row or Command.objects.select_related("issued_by", "grant__robot").filter(pk=stage.id).first()
            except Error:
                close_old_connections()
            if row is not None:
                told |= telling.public(row)
        one.taping.tell("commands", self.now_ns(), msgspec.json.encode(told))

    def _tell_all(self, what: str, text: str) -> None:
        for one in self.running.values():
            one.taping.tell("events", self.now_ns(), _event(what, text, "warning"))

    def _end(self, one: _Running) -> None:
        if self._reader is not None:
            others = {c for other in self.running.values() for c in other.channels()}
            self._reader.unsubscribe(set(one.channels()) - others)
        one.taping.close()
        self._ending.append(one)

    def _settle(self, one: _Running) -> None:
        """Say in the database how a recording ended."""
        end = one.taping.end
        if not Recording.objects.filter(pk=one.row.pk).exists():
            return  # the robot was deleted meanwhile; housekeeping removes the file
        one.grant.refresh_from_db()
        state = RecordingState.READY if end.whole else RecordingState.CUT
        ended = one.grant.ended_at or self._clock.now() + self._offset
        try:
            keeping.finish(one.row, state, end.reason, ended, end.dropped)
        except (OSError, ValueError):  # one bad file ends no recorder; housekeeping comes back to it
            log.exception("%s could not be finished", one.row)
        bus.publish(one.slug, Changed("log"))

    def _settle_left(self) -> None:
        """Finish what this host's recorder had begun when it was killed, and whose grant has ended since."""
        for row in keeping.left_by(self._host):
            try:
                keeping.salvage(row)
            except (OSError, ValueError):  # one bad file ends no recorder
                log.exception("%s could not be finished", row)

    def _end_all(self) -> None:
        """The recorder stops: its files are closed, the rows say so; recordings of open grants go on with the next."""
        if self._movies is not None:
            self._movies.close()
        for one in [*self.running.values(), *self._ending]:
            one.taping.close()
        for one in [*self.running.values(), *self._ending]:
            one.taping.written.wait(5.0)
        for one in self.running.values():  # the next recorder goes on with the file
            if one.taping.end.whole and keeping.path_of(one.row).exists():
                keeping.path_of(one.row).replace(keeping.live_path(one.row))
        try:
            for one in self._ending:
                self._settle(one)
        except Error as error:
            log.warning("how recordings ended is told later: %s", error)


def _event(what: str, text: str, level: str) -> bytes:
    return msgspec.json.encode({"what": what, "text": text, "level": level})


def wait_for_lock(over: Callable[[], bool], take: Callable[[], bool]) -> bool:
    """Wait until this is the only recorder of the host. Return False if `over` came first."""
    while not take():
        if over():
            return False
        SYSTEM.sleep(1.0)
    return True
