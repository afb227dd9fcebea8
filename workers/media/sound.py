"""The sound of one robot, encoded once for all who listen, while somebody does.

The thread begins with the first listener and ends after the last; it holds no lock that anything else waits for, and
keeps nothing: a packet that Redis does not take at once is lost. What fails here is told to those who listen, and tried
again after a pause; the robot, its pictures and its commands do not depend on it.
"""

import contextlib
import logging
import os
import threading
from contextlib import closing

from django.db import Error, connections

from robots import bus
from robots.kit.clock import Clock
from robots.kit.contract.sound import SoundPacket, pack, sentence
from robots.models import Robot
from robots.services.incidents import incident
from workers.media.microphone import PIECE_MS, Encoder, Microphone, MicrophoneFault

log = logging.getLogger(__name__)
LINGER_S = 1.0  # after the last time that somebody was found to listen
PAUSE_S, LONGEST_PAUSE_S = 1.0, 15.0  # before another attempt
SAY_S = 1.0  # between two times that those who listen are told why they hear nothing
TOLD_S = 3600.0  # between two incidents
REMEDY = "Those who listen are told so; it is tried again while somebody listens."
DEPTH = 5.0  # pieces that may come at once (in `Pacer`)
MOST = 100.0  # pieces left out one after another, before their source is slowed down
FORGET = 0.01  # of a piece left out, with each that was due
OURS = "The sound failed; the log of the robot's worker says why."


class Pacer:
    """Paces pieces of sound of `every_s` (s): they follow each other as fast as they are heard. `now` is monotonic (s).

    What was missed in a pause on the way comes at once, and some servers begin with the last seconds: that is left out,
    because listeners want the present. A source that is faster all the time, as a file is, is slowed down.
    """

    def __init__(self, every_s: float, now: float) -> None:
        self._every_s, self._at = every_s, now
        self._room, self._left_out = DEPTH, 0.0

    def wait_s(self, now: float) -> float | None:
        """Return how long to wait before the next piece is sent (s), usually 0; None to leave it out."""
        due, self._at = max(0.0, now - self._at) / self._every_s, now
        self._room = min(DEPTH, self._room + due)
        self._left_out = max(0.0, self._left_out - FORGET * due)
        if self._room < 1.0 and self._left_out < MOST:
            self._left_out += 1.0
            return None
        self._room -= 1.0
        return max(0.0, -self._room * self._every_s)


class Sound:
    """Hears a robot's microphone while it is wanted."""

    def __init__(self, slug: str, clock: Clock) -> None:
        self._slug, self._clock = slug, clock
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._robot: Robot | None = None
        self._until = 0.0
        self._pause_s, self._failing = PAUSE_S, ""
        self._told_at = float("-inf")
        self._run, self._number = os.urandom(1)[0], 0

    def look(self, robot: Robot) -> None:
        """Begin to hear the robot, or go on, if somebody listens now. Raises redis.RedisError."""
        if not robot.microphone:
            self._until = 0.0
        elif bus.watched(self._slug, bus.SOUND):
            self.want(robot)

    def want(self, robot: Robot) -> None:
        """Hear the robot for about another second; returns at once."""
        with self._lock:
            self._robot, self._until = robot, self._clock.monotonic() + LINGER_S
            if self._thread is None:
                with contextlib.suppress(RuntimeError):  # the system has no thread left: the next look tries again
                    self._thread = self._clock.spawn(self._hear, "sound")

    @property
    def running(self) -> bool:
        """Tell whether its thread runs."""
        return self._thread is not None

    def _wanted(self) -> Robot | None:
        """Return the robot while somebody listens; None ends the thread."""
        with self._lock:
            if self._clock.monotonic() < self._until:
                return self._robot
            self._thread, self._failing, self._pause_s = None, "", PAUSE_S
            return None

    def _goes_on(self, address: str) -> bool:
        robot = self._robot
        return self._clock.monotonic() < self._until and robot is not None and robot.microphone == address

    def _hear(self) -> None:
        try:
            while (robot := self._wanted()) is not None:
                self._try(robot)
        finally:
            with self._lock:
                if self._thread is threading.current_thread():  # it failed; the next look begins anew
                    self._thread = None

    def _try(self, robot: Robot) -> None:
        try:
            self._follow(robot)
        except MicrophoneFault as error:
            self._fail(robot, str(error))
        except Exception:
            log.exception("the sound failed")
            self._fail(robot, OURS)

    def _follow(self, robot: Robot) -> None:
        """Send what the microphone hears until nobody listens or it has another address. Raises MicrophoneFault."""
        self._run = (self._run + 1) & 0xFF
        encoder = Encoder()
        with closing(Microphone(robot.microphone, robot.rig_dir)) as microphone:
            pacer = Pacer(PIECE_MS / 1000, self._clock.monotonic())
            for piece in microphone.pieces():
                if not self._goes_on(robot.microphone):
                    return
                self._number += 1
                wait_s = pacer.wait_s(self._clock.monotonic())
                if wait_s is None:
                    continue
                self._clock.sleep(wait_s)
                at_ms = self._now_ms() - PIECE_MS
                if data := encoder.encode(piece):
                    bus.publish_sound(self._slug, pack(SoundPacket(self._number, at_ms, PIECE_MS, data, self._run)))
                self._failing, self._pause_s = "", PAUSE_S

    def _now_ms(self) -> int:
        return int(self._clock.now().timestamp() * 1000)

    def _fail(self, robot: Robot, text: str) -> None:
        """Tell those who listen, and staff, then wait for a while."""
        if text != self._failing:
            log.warning("sound: %s", text)
            self._tell_staff(robot, text)
        self._failing = text
        until = self._clock.monotonic() + self._pause_s
        self._pause_s = min(2 * self._pause_s, LONGEST_PAUSE_S)
        while self._clock.monotonic() < until and self._goes_on(robot.microphone):
            bus.publish_sound(self._slug, pack(sentence(text, self._now_ms(), self._number, self._run)))
            self._clock.sleep(SAY_S)

    def _tell_staff(self, robot: Robot, text: str) -> None:
        now = self._clock.monotonic()
        if now - self._told_at < TOLD_S:
            return
        self._told_at = now
        try:
            incident(robot, "microphone", text, self._clock.now(), remedy=REMEDY)
        except Error as error:
            log.warning("the incident could not be kept: %s", error)
        finally:
            connections.close_all()  # of this thread, which will end
