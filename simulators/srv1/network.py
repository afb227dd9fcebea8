"""The Wi-Fi module's TCP port: who connects is given to the link, byte for byte."""

import contextlib
from functools import partial

from robots.kit.clock import TIMER, Timer
from simulators.common.journal import Note
from simulators.common.tcp import Line, Listener
from simulators.srv1.link import Link

PIECE = 4096
AGAIN_S = 0.05  # after a connection that could not be taken


class TcpPeer:
    """The present client behind a connection; see `link.Peer`."""

    def __init__(self, line: Line, name: str) -> None:
        self.line, self.name = line, name

    def say(self, data: bytes) -> None:
        """See `link.Peer`; who does not read for a while is disconnected."""
        try:
            self.line.sendall(data)
        except OSError:
            self.cut()

    def cut(self) -> None:
        """See `link.Peer`."""
        with contextlib.suppress(OSError):
            self.line.shut()


class Network:
    """Serves a link to those that connect: threads of `clock`."""

    def __init__(self, link: Link, note: Note, clock: Timer = TIMER) -> None:
        self._link, self._note, self._clock = link, note, clock
        self._open = True
        self._listener: Listener | None = None

    def listen(self, listener: Listener) -> None:
        """Let clients connect."""
        self._listener = listener
        self._clock.spawn(partial(self._listen, listener), "network")

    def close(self) -> None:
        """Let nobody connect any more; end the present connection."""
        self._open = False
        if self._listener is not None:
            self._listener.close()
        self._link.close()

    def _listen(self, listener: Listener) -> None:
        while self._open:
            try:
                line, _, name = listener.accept()
            except OSError:
                self._clock.sleep(AGAIN_S)  # closed, or no descriptors left for now
                continue
            peer = TcpPeer(line, name)
            if not self._link.join(peer):
                peer.cut()
                line.close()
                continue
            try:
                self._clock.spawn(partial(self._serve, peer), "reader")
            except RuntimeError:  # the system has no thread left for now
                self._left(peer)

    def _serve(self, peer: TcpPeer) -> None:
        try:
            while data := peer.line.receive(PIECE):
                self._link.take(peer, data)
        except OSError:
            pass
        except Exception as error:  # noqa: BLE001 - one client must not end the others' service
            self._note("crash", error=f"{type(error).__name__}: {error}")
        self._left(peer)

    def _left(self, peer: TcpPeer) -> None:
        self._link.leave(peer)
        peer.line.close()
