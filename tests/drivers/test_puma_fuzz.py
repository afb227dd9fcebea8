"""Promise 44 for the PUMA 560: lines of all kinds, and rubbish; none does harm, and each line is answered."""

from collections import OrderedDict

import pytest
from hypothesis import event
from hypothesis import strategies as st

from tests.conftest import at_length
from tests.drivers.fuzzing import Watched, pieces, play_rounds, weighted
from tests.drivers.puma_wire import (
    ACK,
    BOX,
    CALIBRATE,
    CHECKSUM,
    GRIP,
    HOLD,
    JOG_JOINTS,
    JOG_TOOL,
    JOINTS,
    LINE,
    NAK,
    NUMBERS,
    POSE,
    RESET,
    STALE,
    STATE,
    STATUS,
    UNKNOWN,
    Terminal,
    line,
)
from tests.rig import PumaSimulator

pytestmark = pytest.mark.timed

A_ROUND = 30  # lines written in one go
BAUD = 4_000_000
REMEMBERED = 32
COUNTS = {JOINTS: 8, POSE: 8, LINE: 8, JOG_JOINTS: 7, JOG_TOOL: 7, GRIP: 2, CALIBRATE: 1, RESET: 0, STATUS: 0, HOLD: 0}
WILD = (0, 1, -1, 999_999_999, -999_999_999, 720_000, 720_001, -200_001, 1_000_000)
LATEST = "latest"  # stands for a clock that has not passed yet

small = st.integers(-3_000, 3_000)
speeds = st.integers(-30_000, 30_000)
usual = {
    JOINTS: st.tuples(st.just(LATEST), st.integers(50, 1000), *[small] * 6),
    POSE: st.tuples(st.just(LATEST), st.integers(50, 1000), *[small] * 3, *[st.integers(-180_000, 180_000)] * 3),
    LINE: st.tuples(st.just(LATEST), st.integers(50, 1000), *[small] * 3, *[st.integers(-180_000, 180_000)] * 3),
    JOG_JOINTS: st.tuples(st.just(LATEST), *[speeds] * 6),
    JOG_TOOL: st.tuples(st.just(LATEST), *[speeds] * 6),
    GRIP: st.tuples(st.just(LATEST), st.integers(0, 1)),
    BOX: st.just(()),
}


def numbers_of(code):
    """Generate numbers that fit, wild ones, and too few or too many."""
    wild = st.lists(st.sampled_from(WILD), min_size=COUNTS.get(code, 6), max_size=COUNTS.get(code, 6)).map(tuple)
    odd = st.lists(st.sampled_from(WILD), max_size=14).map(tuple)
    return weighted((6, usual.get(code, st.just(()))), (2, wild), (1, odd))


instructions = st.sampled_from([JOINTS] * 4 + [POSE, LINE, JOG_JOINTS, JOG_JOINTS, JOG_TOOL, GRIP, BOX, STATUS, HOLD])
codes = weighted((15, instructions), (1, st.integers(0, 999_999)))
steps = weighted((12, st.just(1)), (1, st.sampled_from([0, -1, -20, -40, 3, 60, 127, 128])))
whole = st.tuples(st.just("line"), steps, codes.flatmap(lambda c: st.tuples(st.just(c), numbers_of(c))))
rubbish = st.tuples(st.just("rubbish"), st.just(0), st.binary(min_size=1, max_size=300).filter(lambda b: b[-1] != 13))
cut = st.tuples(st.just("cut"), st.integers(0, 255), st.integers(1, 15))
spoilt = st.tuples(st.just("spoilt"), st.integers(0, 255), st.tuples(st.integers(1, 12), st.integers(1, 127)))
rounds_of_bytes = st.lists(
    weighted((17, whole), (1, rubbish), (1, cut), (1, spoilt)), min_size=A_ROUND, max_size=A_ROUND
)


class Memory:
    """The rule for numbers: known ones are answered as before, older ones refused, whatever they contain."""

    def __init__(self):
        self.newest, self.answers = None, OrderedDict()

    def judge(self, code, seq, numbers, answer):
        """Check one answer (code and error) against the rules, and remember it."""
        if code == STATUS:
            assert answer == ((NAK, NUMBERS) if numbers else (STATE, None))
            return
        fresh = self.newest is None or 0 < (seq - self.newest) % 256 < 128
        before, known = self.answers.get(seq, (None, None))
        if not fresh and known is not None and (code != HOLD or before == HOLD):
            assert answer == known, "a known number was not answered as the first time"
            return
        if not fresh and code != HOLD:
            assert answer == (NAK, STALE)
            return
        if fresh:
            self.newest = seq
            self.answers.pop(seq, None)
        if code == RESET and not numbers:
            assert answer == (ACK, None)
            self.answers.clear()
        self.answers.setdefault(seq, (code, answer))
        while len(self.answers) > REMEMBERED:
            self.answers.popitem(last=False)
        if not 1 <= code <= BOX:
            assert answer == (NAK, UNKNOWN)
        elif code == BOX:
            assert len(numbers) in (0, 6) or answer == (NAK, NUMBERS)
        elif len(numbers) != COUNTS[code]:
            assert answer == (NAK, NUMBERS)
        elif code == HOLD:
            assert answer == (ACK, None)
        event(f"{code} {answer}")


class Fuzz(Watched):
    """The line under fuzz: what was sent, what it has to say to it."""

    def __init__(self, sim):
        super().__init__(sim)
        self.wire = Terminal(sim.folder / "tty")
        self.memory, self.seq = Memory(), 0

    def play(self, items, cuts):
        """Write one round, read what it says, judge each answer in its order."""
        out, wanted, latest = bytearray(), [], self.wire.latest(30)
        for kind, number, what in items:
            if kind == "line":
                seq = (self.seq + number) % 256
                self.seq = seq if 0 < number < 128 else self.seq
                code, about = what
                numbers = tuple(latest if one == LATEST else one for one in about)
                out += line(code, seq, *numbers)
                wanted.append((code, seq, numbers))
            elif kind == "rubbish":
                out += what
            elif kind == "cut":
                out += line(JOINTS, number, latest, 500, *[0] * 6)[:what]
            else:
                broken = bytearray(line(RESET, number))
                broken[what[0] % len(broken)] ^= what[1]
                out += broken
        self.wire.heard.clear()
        for piece in pieces(bytes(out), cuts):
            self.wire.write(piece)
        self.tried += len(items)

        def answers(heard):
            told = [(one[0], one[1], one[4] if one[0] == NAK else None) for one in heard]
            return [one for one in told if one[::2] != (NAK, CHECKSUM)]

        self.wire.until(lambda heard: len(answers(heard)) >= len(wanted), 10)
        told = answers(self.wire.heard)
        self.unanswered += abs(len(wanted) - len(told))
        assert [one[1] for one in told] == [one[1] for one in wanted], "each line is answered in its order"
        for (code, seq, numbers), (reply, _, error) in zip(wanted, told, strict=True):
            self.memory.judge(code, seq, numbers, (reply, error))

    def calibrate(self):
        """Begin where motions are accepted, under numbers that are new."""
        for code in (RESET, CALIBRATE):
            self.seq = ((self.seq if self.memory.newest is None else self.memory.newest) + 1) % 256
            about = (self.wire.latest(),) if code == CALIBRATE else ()
            answer = self.wire.ask(code, self.seq, *about)
            self.memory.judge(code, self.seq, about, answer)
            assert answer == (ACK, None), (code, self.tried)
        self.wire.ended(60)


@pytest.fixture
def fuzz(tmp_path):
    sim = PumaSimulator(tmp_path, baud=BAUD, seed=3)
    made = Fuzz(sim)
    yield made
    made.wire.close()
    sim.stop()


@pytest.mark.asvs("1.3.3", "1.4.2")
@pytest.mark.parametrize("part", [1, *map(at_length, (2, 3, 4))])
def test_promise_44_a_hostile_wire_client_changes_nothing_of_the_puma(fuzz, proof, part):
    number = proof.count("lines and pieces of rubbish", 900, 25_000)
    play_rounds(fuzz, part, number, A_ROUND, 10, rounds_of_bytes)
    assert fuzz.sim.count("motion") > number / 200, "it moved, so that there was something to spoil"
    proof.holds(f"{fuzz.figure()}; {fuzz.sim.count('motion')} motions, {fuzz.sim.count('hold')} holds")
