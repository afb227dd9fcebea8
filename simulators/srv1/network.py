"""The Wi-Fi module's TCP port: it hands the bytes of a client to the link, and those of the link to the client."""

import contextlib
from functools import partial

from robots.kit.clock import TIMER, Timer
from simulators.common.journal import Note
from simulators.common.tcp import Line, Server
from simulators.srv1.link import Link

PIECE = 4096


class TcpPeer:
    """The present client behind a connection; see `link.Peer`."""

    def __init__(self, line: Line, name: str) -> None:
        self.line, self.name = line, name

    def say(self, data: bytes) -> None:
        """See `link.Peer`; a client that does not read for a while is disconnected."""
        try:
            self.line.sendall(data)
        except OSError:
            self.cut()

    def cut(self) -> None:
        """See `link.Peer`."""
        with contextlib.suppress(OSError):
            self.line.shut()


class Network(Server):
    """Serves a link to the clients that connect: threads of `clock`."""

    def __init__(self, link: Link, note: Note, clock: Timer = TIMER) -> None:
        super().__init__(clock)
        self._link, self._note = link, note

    def close(self) -> None:
        """Accept no more connections; end the present one."""
        super().close()
        self._link.close()

    def _accept(self, line: Line, host: str, name: str) -> None:
        peer = TcpPeer(line, name)
        if not self._link.join(peer):
            peer.cut()
            line.close()
            return
        try:
            self._clock.spawn(partial(self._serve, peer), "reader")
        except RuntimeError:  # the system has no thread left for now
            self._leave(peer)

    def _serve(self, peer: TcpPeer) -> None:
        try:
            while data := peer.line.receive(PIECE):
                self._link.take(peer, data)
        except OSError:
            pass
        except Exception as error:  # noqa: BLE001 - one client must not end the others' service
            self._note("crash", error=f"{type(error).__name__}: {error}")
        self._leave(peer)

    def _leave(self, peer: TcpPeer) -> None:
        self._link.leave(peer)
        peer.line.close()
