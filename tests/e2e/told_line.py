"""A page's clock and its line about its person's places, both moved by hand: no test waits for a countdown."""

import json
import re
from datetime import timedelta

from portal.live.standing import act, places
from queueing import services as queue
from queueing.services import standings
from robots import bus
from robots.kit.clock import SYSTEM
from tests.e2e.frames import read
from tests.waiting import CEILING_S, wait_for

ANY_LINE, OWN_LINE = re.compile("/ws/"), re.compile("/ws/me/")
STEP_S = 4


def stopped_clock(page):
    """Stop the clock of a page before it is opened; return the time of day that it shows from now on."""
    now = SYSTEM.now()
    page.clock.install(time=now)
    now += timedelta(seconds=1)
    page.clock.pause_at(now)
    return now


def own_time(page):
    """Let the lines of a page pass all but the server's time, of which it is told once; return what kinds have passed."""
    heard = []

    def opened(socket):
        server = socket.connect_to_server()
        server.on_message(lambda text: passed(socket, text))

    def passed(socket, text):
        said = read(text)
        again = said.get("t") == "pong" and "pong" in heard
        socket.send(json.dumps(said | {"n": 0}) if again else text)  # answers no ping: somebody is there
        heard.append(said.get("t"))

    page.route_web_socket(ANY_LINE, opened)
    return heard


def run_heard(page, heard, ms):
    """Let the page's time pass in steps, and something be heard after each: a busy server does not count as silent."""
    for step in [1000] * (ms // 1000) + [ms % 1000]:
        before = len(heard)
        page.clock.run_for(step)
        wait_for(lambda before=before: page.wait_for_timeout(0) or len(heard) > before, CEILING_S, "the server")


class ToldLine:
    """The server's side of `/ws/me/` on the page's own stopped clock: rows by services, words by the consumer's."""

    def __init__(self, page, user):
        self.page, self.user = page, user
        self.now = stopped_clock(page)
        self._socket, self._tells, self._runs = None, False, False
        page.route_web_socket(OWN_LINE, self._opened)

    def _opened(self, socket):
        """Begin with the places, as the server does, once there are any to be told."""
        socket.on_message(lambda text: self._asked(socket, read(text)))
        self._socket = socket
        self._look()

    def _look(self):
        """Tell a page that asks, not while its clock runs: it would take an older time for the present one."""
        if self._tells and not self._runs:
            self._send()

    def _asked(self, socket, asked):
        if asked.get("t") == "look":
            self._look()
        if asked.get("t") == "do":
            wrong = act(self.user, asked["what"], asked["robot"], asked["ticket"], self.now)
            answer = {"t": "answer", "to": asked["what"], "robot": asked["robot"], "ok": not wrong, "text": wrong}
            socket.send(json.dumps(answer))
            self._look()

    def _send(self):
        bus.connection().set(
            bus.web_up_key(), (self.now - timedelta(hours=1)).timestamp()
        )  # people could come all along
        self._socket.send(json.dumps(places(standings(self.user, self.now), self.now)))

    def tell(self):
        """Tell the places as they are now."""
        wait_for(lambda: self.page.wait_for_timeout(0) or self._socket, CEILING_S, "the page's line")
        self._tells = True
        self._send()

    def serve(self):
        """Advance the queues, as housekeeping does each second, and tell what came of it."""
        queue.tick(self.now)
        self.tell()

    def go(self, seconds):
        """Let so much time pass; the page is told each few seconds, which is sooner than it doubts that it is heard."""
        while seconds > 0:
            step = min(seconds, STEP_S)
            self._runs = True
            self.page.clock.run_for(round(1000 * step))
            self._runs = False
            self.now += timedelta(seconds=step)
            seconds -= step
            if seconds > 0:
                self.tell()
