"""A proxy that breaks lines on purpose: in front of Redis, PostgreSQL and robots on TCP.

The well-kept one of this kind (Toxiproxy) is a Go program that Python packages only drive,
so this is ours. Modes: `pass`; `delay` by a time; `stall` (open, nothing passes); `half`
(what the server says is lost); `spoil` (one byte in a thousand is another); `slow` (what the server says comes at so
many bytes a second); `cut` (closed, and refused); `reset` (RST).
"""

import contextlib
import random
import select
import socket
import struct
import threading
import time  # noqa: TID251 - it is a line that is slow
from pathlib import Path

PIECE, SLOW_PIECE = 65536, 256
SPOILT = 0.001


class Proxy:
    """Listens on `at` and forwards to `to`; each a path of a Unix socket or (host, port)."""

    def __init__(self, at, to, buffer=0):
        """`buffer`: bytes of the receive buffer towards the server, where a slow line must not hide in it."""
        self.at, self.to = at, to
        self.mode, self.delay_s, self.bytes_s = "pass", 0.0, 0.0
        self._buffer = buffer
        self._dice = random.Random(1)
        self._pairs: set[tuple[socket.socket, socket.socket]] = set()
        self._server: socket.socket | None = None
        self._running = True
        self._listen()

    def _listen(self):
        if isinstance(self.at, str):
            with contextlib.suppress(FileNotFoundError):
                Path(self.at).unlink()
            server = socket.socket(socket.AF_UNIX)
        else:
            server = socket.socket()
            server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        server.bind(self.at)
        server.listen(64)
        self._server = server
        threading.Thread(target=self._accept, args=(server,), daemon=True).start()

    def _accept(self, server):
        while self._running and server is self._server:
            try:
                client, _ = server.accept()
            except OSError:
                return
            if self.mode in ("cut", "reset"):
                client.close()
                continue
            upstream = socket.socket(socket.AF_UNIX if isinstance(self.to, str) else socket.AF_INET)
            if self._buffer:
                for one in (upstream, client):
                    one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, self._buffer)
            try:
                upstream.connect(self.to)
            except OSError:
                client.close()
                upstream.close()
                continue
            pair = (client, upstream)
            self._pairs.add(pair)
            for source, sink, back in ((client, upstream, False), (upstream, client, True)):
                threading.Thread(target=self._pump, args=(pair, source, sink, back), daemon=True).start()

    def _pump(self, pair, source, sink, back):
        try:
            while self._running:
                if self.mode == "stall" or (self.mode == "half" and back):
                    time.sleep(0.005)
                    continue
                if not select.select([source], [], [], 0.05)[0]:
                    continue
                if self.mode == "stall" or (self.mode == "half" and back):
                    continue
                slow = self.mode == "slow" and back
                data = source.recv(SLOW_PIECE if slow else PIECE)
                if not data:
                    break
                if slow:
                    time.sleep(len(data) / self.bytes_s)
                if self.delay_s:
                    time.sleep(self.delay_s)
                sink.sendall(self._spoilt(data) if self.mode == "spoil" else data)
        except (OSError, ValueError):
            pass
        finally:
            self._close(pair)

    def _spoilt(self, data):
        return bytes(self._dice.randrange(256) if self._dice.random() < SPOILT else byte for byte in data)

    def _close(self, pair):
        self._pairs.discard(pair)
        for one in pair:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()

    def set(self, mode, delay_s=0.0, bytes_s=0.0):
        """Change the mode; `cut` and `reset` close what is open."""
        self.mode, self.delay_s, self.bytes_s = mode, delay_s, bytes_s
        if mode in ("cut", "reset"):
            for pair in list(self._pairs):
                if mode == "reset":
                    with contextlib.suppress(OSError):
                        pair[0].setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                self._close(pair)

    @property
    def carries(self):
        """Tell whether somebody is connected through it."""
        return bool(self._pairs)

    def close(self):
        self._running = False
        server, self._server = self._server, None
        if server is not None:
            with contextlib.suppress(OSError):
                server.shutdown(socket.SHUT_RDWR)
            server.close()
        for pair in list(self._pairs):
            self._close(pair)
        if isinstance(self.at, str):
            with contextlib.suppress(FileNotFoundError):
                Path(self.at).unlink()
