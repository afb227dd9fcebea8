"""A page that watches, as a thread: what came over its socket, and when."""

import json
import threading
import time  # noqa: TID251 - only timed tests may import it


class Watching:
    """Reads a socket to its end; notes the times at which pictures came, and keeps the words."""

    def __init__(self, socket):
        self.pictures, self.heard = [], []
        self._socket = socket
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        try:
            for data in self._socket:
                if isinstance(data, str):
                    self.heard.append(json.loads(data))
                elif data[0] == 2:
                    self.pictures.append(time.monotonic())
        except Exception:
            return

    def rate(self, seconds):
        """Return how many pictures a second came during the last `seconds`."""
        since = time.monotonic() - seconds
        return sum(at >= since for at in self.pictures) / seconds
