"""Serves sound as an ordinary network microphone: an endless WAV file, computed while somebody is connected."""

import select
import socket
import struct
import threading
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robots.kit.clock import TIMER, Timer
from simulators.common.faults import FaultBoard

RATE = 16_000  # samples a second, of one channel and 16 bits
BLOCK_S = 0.04
LATE_S = 1.0  # sound that is later than this is skipped
ENDLESS = 0xFFFFFFFF  # the length of a file without an end, as FFmpeg and sox write it


class Sound(Protocol):
    """The sound for one listener."""

    def hear(self, since: float, until: float, count: int) -> NDArray[np.float32]:
        """Return `count` samples from -1 to 1 of the time from `since` to `until` (s, of its clock)."""


def head(rate: int = RATE) -> bytes:
    """Return the head of an endless WAV file: PCM, one channel, 16 bits."""
    form = struct.pack("<4sIHHIIHH", b"fmt ", 16, 1, 1, rate, 2 * rate, 2, 16)
    return struct.pack("<4sI4s", b"RIFF", ENDLESS, b"WAVE") + form + struct.pack("<4sI", b"data", ENDLESS)


def _gone(line: socket.socket) -> bool:
    """Return whether the listener has closed the connection."""
    return bool(select.select([line], [], [], 0)[0]) and not line.recv(1, socket.MSG_PEEK)


class Microphone:
    """One microphone; `sound` makes the sound for a new listener."""

    path = "/microphone.wav"

    def __init__(self, sound: Callable[[], Sound], faults: FaultBoard, clock: Timer = TIMER) -> None:
        self._sound, self._faults, self._clock = sound, faults, clock
        self._lock = threading.Lock()
        self.listeners = self.openings = 0

    def answer(self, request: BaseHTTPRequestHandler) -> None:
        """Send sound until the listener goes, or the microphone is gone. Raises ConnectionError, BrokenPipeError."""
        request.close_connection = True
        if self._faults.value("mic_gone"):
            return
        request.send_response(200)
        request.send_header("Content-Type", "audio/wav")
        request.send_header("Cache-Control", "no-store")
        request.send_header("Connection", "close")
        request.end_headers()
        request.wfile.write(head())
        self._count(1)
        try:
            self._send(request)
        finally:
            self._count(-1)

    def _count(self, change: int) -> None:
        with self._lock:
            self.listeners += change
            self.openings += max(0, change)

    def _send(self, request: BaseHTTPRequestHandler) -> None:
        sound, count, at = self._sound(), int(RATE * BLOCK_S), self._clock.monotonic()
        while not self._faults.value("mic_gone"):
            self._clock.sleep(max(0.0, at + BLOCK_S - self._clock.monotonic()))
            if self._clock.monotonic() - at > LATE_S:
                at = self._clock.monotonic() - BLOCK_S
            heard = sound.hear(at, at + BLOCK_S, count)
            at += BLOCK_S
            if self._faults.value("mic_mute"):
                if _gone(request.connection):
                    return
            else:
                request.wfile.write((np.clip(heard, -1.0, 1.0) * 32767).astype("<i2").tobytes())
