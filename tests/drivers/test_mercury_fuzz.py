"""Promise 44 for the Mercury arm: 100 000 frames of all kinds; none does harm, and each is answered."""

from collections import OrderedDict
from itertools import combinations

import pytest
from hypothesis import event
from hypothesis import strategies as st

from tests.conftest import at_length
from tests.drivers.fuzzing import Watched, numbers, pieces, play_rounds, weighted
from tests.drivers.mercury_wire import (
    ACK,
    AIR,
    BURY,
    CALIBRATE,
    CHECKSUM,
    HOLD,
    LENGTH,
    MOVE_THETA,
    MOVE_XYZ,
    NAK,
    RANGE,
    RESET,
    SPEED,
    STALE,
    STATE,
    STATUS,
    UNKNOWN,
    Terminal,
    floats,
    frame,
)
from tests.rig import Simulator

pytestmark = pytest.mark.timed

A_ROUND = 50  # frames written in one go
BAUD = 4_000_000
SIZES = {MOVE_XYZ: 12, MOVE_THETA: 4, AIR: 4, SPEED: 4, BURY: 4, RESET: 0, CALIBRATE: 0, STATUS: 0, HOLD: 0}
GREATEST = {MOVE_XYZ: 10_000.0, MOVE_THETA: 360.0, AIR: 60.0, SPEED: 10_000.0, BURY: 2**24 - 1}
REMEMBERED = 32

usual = {
    MOVE_XYZ: st.tuples(st.floats(-240, 240), st.floats(290, 550), st.sampled_from([0.0, 75.0])),
    MOVE_THETA: st.tuples(st.floats(-180, 180)),
    AIR: st.tuples(st.floats(0.05, 0.5)),
    SPEED: st.tuples(st.floats(20, 600)),
}


def data_of(instruction):
    """Generate data that fits, with any numbers, and data that does not."""
    size = SIZES.get(instruction, 4) // 4
    wild = st.tuples(*[numbers()] * size).map(lambda v: floats(*v))
    right = usual[instruction].map(lambda v: floats(*v)) if instruction in usual else st.just(b"")
    return weighted((5, right), (3, wild), (1, st.binary(max_size=47)))


instructions = st.sampled_from([MOVE_XYZ] * 6 + [MOVE_THETA] * 3 + [AIR] * 2 + [SPEED, STATUS, STATUS, HOLD])
ids = weighted((15, instructions), (1, st.integers(0, 255)))  # a whole reset is rare, so that motions are accepted
steps = weighted((12, st.just(1)), (1, st.sampled_from([0, -1, -20, -40, 3, 60, 127, 128])))
asked = st.tuples(st.just("frame"), steps, ids.flatmap(lambda i: st.tuples(st.just(i), data_of(i))))
rubbish = st.tuples(st.just("rubbish"), st.just(0), st.binary(min_size=1, max_size=60))
cut = st.tuples(st.just("cut"), st.integers(0, 255), st.tuples(ids, st.binary(max_size=20), st.integers(1, 20)))
spoilt = st.tuples(st.just("spoilt"), st.integers(0, 255), st.tuples(ids, st.integers(0, 5), st.integers(1, 255)))
rounds_of_bytes = st.lists(
    weighted((17, asked), (1, rubbish), (1, cut), (1, spoilt)), min_size=A_ROUND, max_size=A_ROUND
)


class Memory:
    """The README's rule for numbers: known ones are answered as before, older ones refused, whatever they contain."""

    def __init__(self):
        self.newest, self.answers = None, OrderedDict()

    def judge(self, instruction, seq, data, answer):
        """Check one answer against the rules, and remember it."""
        if instruction == STATUS:
            assert answer == ((NAK, LENGTH) if data else (STATE, None))
            return
        fresh = self.newest is None or 0 < (seq - self.newest) % 256 < 128
        if not fresh and seq in self.answers:
            assert answer == self.answers[seq], "a known number was not answered as the first time"
            return
        if not fresh and instruction != HOLD:
            assert answer == (NAK, STALE)
            return
        if instruction == RESET and not data:
            assert answer[0] == ACK, (instruction, answer, self.tried, self.line.heard[-4:])
            self.answers.clear()
            self.newest = None
        self.newest = seq if fresh or self.newest is None else self.newest
        self.answers[seq] = answer
        while len(self.answers) > REMEMBERED:
            self.answers.popitem(last=False)
        if instruction not in SIZES:
            assert answer == (NAK, UNKNOWN)
        elif len(data) != SIZES[instruction]:
            assert answer == (NAK, LENGTH)
        elif instruction == HOLD:
            assert answer == (ACK, None)
        elif instruction in GREATEST and not all(abs(v) <= GREATEST[instruction] for v in values(data)):
            assert answer == (NAK, RANGE)
        event(f"{instruction:#x} {answer}")


def values(data):
    import struct

    return struct.unpack(f"<{len(data) // 4}f", data)


def torn(spans, size, cuts):
    """Return the indices of the frames between whose halves we paused."""
    places = {c % (size + 1) for c in cuts}
    return [i for i, (begin, end) in enumerate(spans) if any(begin < place < end for place in places)]


def dropped(wanted, told, may_be):
    """Return which of those that may be dropped are missing in the numbers told; none if that does not explain them."""
    chosen = (set(c) for n in range(1, len(may_be) + 1) for c in combinations(may_be, n))
    return next((lost for lost in chosen if [w for i, w in enumerate(wanted) if i not in lost] == told), set())


class Fuzz(Watched):
    """The line under fuzz: what was sent, what it has to say to it."""

    def __init__(self, sim):
        super().__init__(sim)
        self.line = Terminal(sim.folder / "tty")
        self.memory, self.seq = Memory(), 0

    def play(self, items, cuts):
        """Write one round, read what it says, judge each answer in its order."""
        out, wanted, spans = bytearray(), [], []
        for kind, number, what in items:
            if kind == "frame":
                seq = (self.seq + number) % 256
                self.seq = seq if 0 < number < 128 else self.seq
                spans.append((len(out), len(out) + len(frame(what[0], seq, what[1]))))
                out += frame(what[0], seq, what[1])
                wanted.append((what[0], seq, what[1]))
            elif kind == "rubbish":
                out += what
            elif kind == "cut":
                whole = frame(what[0], number, what[1])
                out += whole[: min(what[2], len(whole) - 4)]  # what follows does not complete it by chance
            else:
                broken = bytearray(frame(what[0], number))
                broken[what[1]] ^= what[2]
                out += broken
        self.line.heard.clear()
        for piece in pieces(bytes(out), cuts):
            self.line.write(piece)
        self.tried += len(items)

        def answers(heard):
            told = [(h[0], h[1], h[2][-1] if h[0] == NAK else None) for h in heard if h[0] in (ACK, NAK, STATE)]
            return [t for t in told if t[::2] != (NAK, CHECKSUM)]

        self.line.until(lambda heard: len(answers(heard)) >= len(wanted), 10)
        told = answers(self.line.heard)
        if lost := dropped([w[1] for w in wanted], [t[1] for t in told], torn(spans, len(out), cuts)):
            # on a busy machine 0.1 s passed between its halves; the host sends such a frame again, and so do we
            again = [wanted[i] for i in sorted(lost)]
            wanted = [w for i, w in enumerate(wanted) if i not in lost] + again
            self.line.write(b"".join(frame(*w) for w in again))
            self.line.until(lambda heard: len(answers(heard)) >= len(wanted), 10)
            told = answers(self.line.heard)
        self.unanswered += abs(len(wanted) - len(told))
        assert [t[1] for t in told] == [w[1] for w in wanted], "each frame is answered under its number, in its order"
        for (instruction, seq, data), (reply, _, error) in zip(wanted, told, strict=True):
            self.memory.judge(instruction, seq, data, (reply, error))

    def calibrate(self):
        """Begin where motions are accepted, under numbers that are new."""
        for instruction in (RESET, CALIBRATE):
            # the numbers of STATUS are not remembered, so ours may have run ahead by half the circle
            self.seq = ((self.seq if self.memory.newest is None else self.memory.newest) + 1) % 256
            answer = self.line.ask(instruction, self.seq)
            self.memory.judge(instruction, self.seq, b"", answer)
            assert answer[0] == ACK, (instruction, answer, self.tried, self.line.heard[-4:])
        self.line.ended(self.seq, 60)


@pytest.fixture
def fuzz(tmp_path):
    sim = Simulator(tmp_path, baud=BAUD)
    made = Fuzz(sim)
    yield made
    made.line.close()
    sim.stop()


@pytest.mark.asvs("1.3.3", "1.4.2")
@pytest.mark.parametrize("part", [1, *map(at_length, (2, 3, 4))])
def test_promise_44_a_hostile_wire_client_changes_nothing(fuzz, proof, part):
    number = proof.count("frames and pieces of rubbish", 800, 25_000)
    play_rounds(fuzz, part, number, A_ROUND, 30, rounds_of_bytes)
    assert fuzz.sim.count("motion") > number / 500, "it moved, so that there was something to spoil"
    proof.holds(
        f"{fuzz.figure()}; {fuzz.sim.count('motion')} motions, {fuzz.sim.count('burst')} bursts, {fuzz.sim.count('hold')} holds"
    )
