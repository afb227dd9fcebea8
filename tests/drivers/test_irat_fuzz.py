"""Promise 44 at the iRat's rosbridge: a crowd of strangers with rubbish, and an owner who drives meanwhile."""

import contextlib
import json
import time

import pytest
from hypothesis import given, seed
from hypothesis import strategies as st
from websockets.exceptions import ConnectionClosed

from tests.conftest import at_length, wait_for
from tests.drivers.fuzzing import WILD, Watched, numbers, rounds, weighted
from tests.drivers.irat_wire import EPOCHS, WireClient
from tests.proof import Proof

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

PARTS, A_ROUND = 5, 12
COMMAND = "/irat/cmd_vel"
odd = weighted(
    (3, numbers()), (1, st.none() | st.booleans() | st.text(max_size=5) | st.lists(st.integers(), max_size=2))
)
parts = st.dictionaries(st.sampled_from("xyzw"), odd, max_size=3)
names = st.sampled_from((COMMAND, "/irat/odom", "irat/state", "/irat/../x", "/", "", "/rosapi/topics")) | st.text(
    max_size=9
)
services = st.sampled_from(("/irat/hold", "/irat/status", "/irat/claim", "/rosapi/services")) | st.text(max_size=9)
frames = st.fixed_dictionaries(
    {"op": st.sampled_from(("publish", "subscribe", "unsubscribe", "advertise", "call_service", "fragment", "status"))},
    optional={
        "topic": names, "service": services, "id": odd, "type": st.text(max_size=9), "compression": st.text(max_size=4),
        "throttle_rate": odd, "msg": st.fixed_dictionaries({}, optional={"linear": parts, "angular": parts}) | odd,
        "args": st.dictionaries(st.just("epoch"), st.sampled_from((*WILD, "1", None, 0.5)), max_size=1) | odd,
    },
).map(json.dumps)  # fmt: skip
items = weighted(
    (4, frames), (1, st.text(max_size=80)), (1, st.binary(max_size=40)), (2, st.tuples(frames, st.integers(1, 300))),
    (1, st.just("cut")), (3, st.just("drive")),
)  # fmt: skip


class Crowd:
    """One owner, and a stranger who comes again whenever the connection has ended."""

    def __init__(self, sim):
        self.sim, self.watched, self.cuts = sim, Watched(sim), 0
        self.claimed, self.owner, self.stranger = set(), None, None

    def play(self, round_of_items):
        self._own()
        for item in round_of_items:
            self.watched.tried += 1
            if item == "drive":
                self.owner.drive(0.1, 0.3)
                continue
            if self.stranger is None:
                self.stranger = WireClient(self.sim)
            with contextlib.suppress(ConnectionClosed, UnicodeEncodeError):
                self._send(item)
        self._own()
        self.watched.unanswered += self.owner.status()["boot"] != self.boot

    def _send(self, item):
        if item == "cut":
            self.cuts += 1
            self.stranger.line.socket.close()
            self.stranger.close()
            self.stranger = None
        elif isinstance(item, tuple):
            self.stranger.send(item[0][: item[1]])
        else:
            self.stranger.send(item)

    def _own(self):
        """Claim again if a stranger has done so with a larger epoch; the owner's is larger still."""
        if self.owner is None:
            self.owner, self.boot = WireClient(self.sim), self.sim.status()["boot"]
        if self.sim.status()["epoch"] not in self.claimed:
            epoch = next(EPOCHS)
            answer = self.owner.claim(epoch)
            if not answer["success"]:  # the stranger's was as large as an epoch can be: only a loss of power helps
                self.sim.fault("power_cycle", count=1)
                wait_for(lambda: self.sim.status()["boot"] != self.boot, 5, "the power")
                self.owner = self.stranger = None
                self._own()
                return
            self.claimed.add(epoch)

    def judge(self):
        self.watched.assert_well()
        assert self.sim.count("crash") == 0
        assert self.owner.call("/irat/hold")["values"]["success"]
        motions = [record for record in self.sim.journal() if record["event"] == "motion"]
        assert motions, "it moved, so that there was something to spoil"
        assert {record["epoch"] for record in motions} <= self.claimed, "nobody but the owner moved it"
        return len(motions)


@pytest.mark.parametrize("part", [0, *(at_length(n) for n in range(1, PARTS))])
def test_promise_44_a_hostile_client_of_the_irat_changes_nothing(request, irat, part):
    proof = Proof.at(request.node)
    number = proof.count("frames and pieces of rubbish, iRat", 300, 100_000 // PARTS)
    crowd = Crowd(irat)

    @seed(part)
    @rounds(-(-number // A_ROUND))
    @given(st.lists(items, min_size=A_ROUND, max_size=A_ROUND))
    def play(round_of_items):
        crowd.play(round_of_items)

    began = time.monotonic()
    play()
    motions = crowd.judge()
    assert crowd.watched.tried >= number * 0.9
    proof.holds(
        f"{crowd.watched.figure()}; {motions} motions of the owner, {crowd.cuts} connections cut, {time.monotonic() - began:.0f} s"
    )
