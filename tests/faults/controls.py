"""The controls of a robot that moves only while somebody holds them."""

import contextlib
import threading
import time  # noqa: TID251 - it holds controls for so long
from collections import deque

from django.db import Error, connection

from robots import bus
from robots.models import Command
from robots.states import COMMAND_FINAL

EVERY_S = 0.06
LOST = "Nothing was heard from your controls"  # of a page or a test that stalled and sent no keep-alives


class Controls(threading.Thread):
    """Keep-alives for one command after the other: until it was acknowledged, and for so many seconds from then on."""

    def __init__(self, slug):
        super().__init__(daemon=True)
        self._slug, self._on, self._lost = slug, True, False
        self._held = deque()  # of commands and seconds, in the order in which they run
        self.start()

    def hold(self, command, seconds):
        """Hold the controls for a command once it is its turn, then release them."""
        self._held.append((command.pk, seconds))

    def lose(self):
        """Say nothing more, as a browser does that is gone."""
        self._lost = True

    def find(self):
        """Send keep-alives again."""
        self._lost = False

    def run(self):
        begun = None
        while self._on:
            with contextlib.suppress(Error):
                begun = self._say(begun)
            time.sleep(EVERY_S)
        connection.close()

    def _say(self, begun):
        """Send one keep-alive; return since when the command that runs is acknowledged, if it is."""
        if not self._held:
            return None
        pk, seconds = self._held[0]
        state = Command.objects.values_list("state", flat=True).filter(pk=pk).first()
        if state is None or state in COMMAND_FINAL:
            self._held.popleft()
            return self._say(None)  # at once: the next one waits for its controls no longer than a quarter of a second
        if begun is None and state == "acknowledged":
            begun = time.monotonic()
        if not self._lost:
            bus.send_keep_alive(self._slug, pk, begun is None or time.monotonic() - begun < seconds)
        return begun

    def close(self):
        self._on = False
        self.join()
