"""A thin line between a browser and the portal: all connections share it, each way so many bytes a second, and late.

Chromium's own throttling of a page reads ahead as fast as it can and hands over slowly, so the portal would not notice
the line, as it does here and over a real one.
"""

import queue
import threading
import time  # noqa: TID251 - it is a line of so many bytes a second

from tests.faults.proxy import Proxy

BUFFER = 4096  # bytes of a connection that wait on the way; more would be a queue that no line of this kind has
PIECE = 256


class ThinLine(Proxy):
    """Passes everything on at once, until it is made `thin`."""

    def __init__(self, at, to):
        self._free_at = {False: 0.0, True: 0.0}  # of each way, when all that was taken has been sent
        self._ways = {False: threading.Lock(), True: threading.Lock()}
        self.late_s = 0.0
        self.carried = 0  # bytes towards the browser
        super().__init__(at, to, buffer=BUFFER)

    def thin(self, bytes_s, round_trip_s=0.0):
        """Carry so many bytes a second each way, and each byte half of that time later."""
        self.bytes_s, self.late_s = bytes_s, round_trip_s / 2

    def _pump(self, pair, source, sink, back):
        on_the_way = queue.SimpleQueue()
        threading.Thread(target=self._deliver, args=(pair, sink, on_the_way), daemon=True).start()
        try:
            while self._running and (data := source.recv(PIECE)):
                self.carried += len(data) if back else 0
                on_the_way.put((self._sent(len(data), back) + self.late_s, data))
        except (OSError, ValueError):
            pass
        finally:
            on_the_way.put((0.0, b""))

    def _sent(self, size, back):
        """Wait until the line has taken so many bytes; return when that was."""
        if not self.bytes_s:
            return time.monotonic()
        with self._ways[back]:
            at = self._free_at[back] = max(self._free_at[back], time.monotonic()) + size / self.bytes_s
        time.sleep(max(0.0, at - time.monotonic()))
        return at

    def _deliver(self, pair, sink, on_the_way):
        try:
            while True:
                at, data = on_the_way.get()
                if not data:
                    break
                time.sleep(max(0.0, at - time.monotonic()))
                sink.sendall(data)
        except OSError:
            pass
        finally:
            self._close(pair)
