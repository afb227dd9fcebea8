"""What a turn sends to a page over a thin line: everything once, then what has changed."""

import json
import time

import pytest
from websockets.frames import Opcode
from websockets.sync.client import connect

from benchmarks.command_round_trip import cookie
from tests.conftest import wait_for
from tests.faults.test_thin_priority import Page
from tests.rig import Web

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

WATCH = {"t": "watch", "cameras": [], "compact": True, "pieces": True}
MOVES = 5
QUIET_S = 2  # after which nothing more comes of a command
MOST_MOVE, MOST_STOP = 300, 500  # bytes of all texts about a command that moves, and about a stop


class Counted:
    """The bytes of the frames of texts that a client reads."""

    def __init__(self, socket):
        (self._deflate,) = socket.protocol.extensions
        self._decode, self._deflate.decode = self._deflate.decode, self._counted
        self.bytes, self.at = 0, time.monotonic()

    def _counted(self, frame, **more):
        if frame.opcode is Opcode.TEXT:
            self.bytes, self.at = self.bytes + len(frame.data) + (2 if len(frame.data) < 126 else 4), time.monotonic()
        return self._decode(frame, **more)

    def quiet(self):
        """Wait until nothing comes any more; return the bytes so far."""
        wait_for(lambda: time.monotonic() - self.at > QUIET_S, 60, "silence")
        return self.bytes


def ended(page, seq):
    return any(told["seq"] == seq and told["state"] == "completed" for *_, told in page.said("command"))


def test_a_turn_takes_few_bytes_after_the_first_snapshot(turntable, people, capsys):
    _, children = turntable()
    children.append(Web())
    at = f"127.0.0.1:{children[2].port}"
    headers = {"Cookie": cookie(people["ada"])}
    with connect(
        f"ws://{at}/ws/robots/turntable/?watch={json.dumps(WATCH, separators=(',', ':'))}", origin=f"http://{at}",
        additional_headers=headers, max_size=None,
    ) as socket:  # fmt: skip
        texts = Counted(socket)
        page = Page(socket)
        wait_for(lambda: page.said("snapshot"), 20, "the snapshot")
        first, moves = texts.quiet(), []
        for seq in range(1, MOVES + 1):
            before = texts.bytes
            socket.send(json.dumps({"t": "command", "kind": "turn", "args": {"angle": 0.3 * seq}, "seq": seq}))
            wait_for(lambda n=seq: ended(page, n), 20, "the end")
            moves.append(texts.quiet() - before)
        before = texts.bytes
        socket.send('{"t":"stop"}')
        wait_for(lambda: any(told["stopped"] for *_, told in page.said("snapshot")), 20, "the stop")
        stop = texts.quiet() - before
        snapshots = page.said("snapshot")
        whole = sum(len(json.dumps(text)) for *_, text in snapshots)
    with capsys.disabled():
        print(f"\n{first} bytes first, then {moves} a move, {stop} a stop; {len(snapshots)} snapshots of {whole} bytes")
    assert snapshots[-1][2]["stopped"]
    assert len(snapshots[-1][2]["commands"]) == MOVES
    assert max(moves) <= MOST_MOVE
    assert stop <= MOST_STOP
