"""Over a thin line what is urgent overtakes what is long: an answer to Stop a picture, and states stay new."""

import json
import threading
import time

import pytest
from websockets.sync.client import connect

from benchmarks.command_round_trip import cookie
from portal.live.pieces import JoinedText
from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.kit.contract.compact import CLOCK
from robots.kit.packets import picture_packet
from robots.states import GrantKind
from tests.conftest import at_length, wait_for
from tests.e2e.thin_line import ThinLine
from tests.rig import free_port

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

WATCH = {"t": "watch", "cameras": [0], "every_s": 5, "compact": True, "pieces": True}
STATE, PICTURE, PIECE = 200, 2, 7  # first bytes
STATE_BYTES, EVERY_S = 19, 0.25
SNAPSHOT = 1 << 20  # characters of the longest text, at most
LONG_S = 25  # what the picture takes of the line alone
MOST_S = 2.5  # of what the line carries, before an answer: what is on the way, a piece, its own bytes


class Page:
    """What comes over a socket: (when, how many bytes came before, message)."""

    def __init__(self, socket):
        self.heard, self._bytes = [], 0
        self._socket = socket
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        try:
            for data in self._socket:
                self.heard.append((time.monotonic(), self._bytes, data))
                self._bytes += len(data)
        except Exception:
            return

    def of(self, first):
        return [one for one in list(self.heard) if not isinstance(one[2], str) and one[2][0] == first]

    def said(self, kind):
        texts, joined = [], JoinedText(SNAPSHOT)
        for at, before, text in list(self.heard):
            if not isinstance(text, str):
                continue
            if (whole := joined.take(text)) is not None:
                texts.append((at, before, json.loads(whole)))
        return [one for one in texts if one[2]["t"] == kind]


def tell_states(slug, running):
    """Publish compact states for ever, each with the time at which it was sent."""
    while not running.is_set():
        ms = int(time.monotonic() * 1000) % CLOCK
        bus.publish_compact(slug, bytes((STATE, ms >> 8, ms & 255)) + bytes(STATE_BYTES - 3))
        time.sleep(EVERY_S)


@pytest.mark.parametrize("bytes_s", [at_length(100), 500, 1000])
def test_the_answer_to_a_stop_overtakes_a_picture_and_states_stay_new(web, robot, people, bytes_s):
    line = ThinLine(("127.0.0.1", free_port()), ("127.0.0.1", web.port))
    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
    headers = {"Cookie": cookie(people["ada"])}
    at = f"127.0.0.1:{line.at[1]}"
    over = threading.Event()
    with connect(
        f"ws://{at}/ws/robots/{robot.slug}/", origin=f"http://{at}", additional_headers=headers, max_size=None
    ) as socket:
        page = Page(socket)
        wait_for(lambda: page.said("snapshot"), 20, "the snapshot")
        socket.send(json.dumps(WATCH))
        threading.Thread(target=tell_states, args=(robot.slug, over), daemon=True).start()
        wait_for(lambda: len(page.of(STATE)) > 4, 20, "states")
        line.thin(bytes_s)
        picture = picture_packet(1, int(time.time() * 1000), 0, (), bytes(LONG_S * bytes_s))
        bus.publish_picture(robot.slug, picture)
        wait_for(lambda: len(page.of(PIECE)) > 3, 60, "pieces of the picture")
        begun, before = time.monotonic(), page.heard[-1][1]
        socket.send('{"t":"stop"}')
        wait_for(lambda: page.said("answer"), 60, "the answer")
        (_, came, answer), *_ = page.said("answer")
        assert answer["to"] == "stop"
        assert answer["ok"], answer
        assert not any(data[2][1] & 2 for data in page.of(PIECE)), "the picture had come already"
        assert came - before <= MOST_S * bytes_s + 100, f"{came - before} bytes came before the answer"
        wait_for(lambda: any(data[2][1] & 2 for data in page.of(PIECE)), 20 * LONG_S, "the end of the picture")
        over.set()
        pieces = [data[2:] for _, _, data in page.of(PIECE)]
        assert b"".join(pieces) == picture
        told = [(int(at * 1000), int.from_bytes(data[1:3], "big")) for at, _, data in page.of(STATE) if at > begun]
        ages_ms = sorted((at_ms - stamp) % CLOCK for at_ms, stamp in told)
        said = f"{came - before} bytes before the answer; states {ages_ms[len(ages_ms) // 2]} to {ages_ms[-1]} ms old"
        assert ages_ms[-1] <= 2000 + 400_000 / bytes_s, said
        print(f"{bytes_s} bytes/s: {said}")
    line.set("cut")
    line.close()
