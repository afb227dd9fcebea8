"""Promise 44 for the museum arm: 100 000 lines of all kinds over TCP; none does harm, and each is answered."""

import contextlib
import json
import socket
import struct
import time

import numpy as np
import pytest
from hypothesis import given, seed, settings
from hypothesis import strategies as st

from robots.kit.drivers.pa10.forms import FORMS
from robots.kit.drivers.pa10.protocol import Malformed, program
from simulators.pa10.store import PROGRAMS
from tests.conftest import at_length
from tests.drivers.fuzzing import Watched, numbers, pieces, rounds, weighted
from tests.proof import Proof
from tests.rig import ArmSimulator

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

A_ROUND = 100  # lines, fewer than may wait for their answers
READY = (0.0, 25.0, 75.0, 0.0, 80.0, 0.0)
NUMBERS = (1, 2, *range(20, 60))
EPOCHS = 10**12  # the greatest that is claimed, so that a newer one always remains
ANSWER_S = 60.0
PARTS = 10  # each with a simulator and inputs of its own


def written(values):
    return " ".join(f"{v:.6g}" for v in values)


def posture(letter):
    """Generate values that the arm may well take, so that there is a motion to spoil."""
    if letter == "j":
        return st.tuples(*[st.floats(-40, 40)] * 6).map(
            lambda d: written([a + b for a, b in zip(READY, d, strict=True)])
        )
    place = st.tuples(st.floats(300, 700), st.floats(-300, 300), st.floats(60, 500), st.floats(150, 210))
    return place.map(lambda v: written((*v[:3], v[3], 0, 180)))


def line_of(letter):
    """Generate a line of a letter: sensible, wild in its numbers, or wrong in their count."""
    form = FORMS[letter]
    inside = st.tuples(*[st.floats(v.low, v.high) for v in form.values[: max(form.least, len(form.values) // 7 * 7)]])
    wild = st.lists(numbers(), min_size=form.least, max_size=len(form.values)).map(lambda v: " ".join(map(repr, v)))
    count = st.lists(numbers(), max_size=9).map(lambda v: " ".join(map(repr, v)))
    sensible = posture(letter) if letter in "jkKl" else inside.map(written)
    if form.values and all(v.whole for v in form.values) and letter in "pg":
        sensible = st.sampled_from(NUMBERS if letter == "p" else (0, 1)).map(str)
    return weighted((6, sensible), (3, wild), (1, count)).map(lambda rest: f"{letter} {rest}".strip())


def claims(text):
    """Tell whether a line would begin an upload, or claim an epoch that no later one can follow."""
    letter, *parts = text.split() or [""]
    with contextlib.suppress(ValueError):
        return letter == "u" or (letter == "i" and bool(parts) and float(parts[0]) > EPOCHS)
    return letter == "u"


LETTERS = "jjjkkllKgJCppwWssbdREi"
grammar = st.sampled_from(LETTERS).flatmap(line_of).filter(lambda text: not claims(text)).map(str.encode)
noise = st.binary(max_size=80).map(lambda b: b.replace(b"\n", b"\r")).filter(lambda b: not claims(b.decode("latin-1")))
odd = st.sampled_from(
    [
        b"",
        b" ",
        b"\x00",
        b"\xff\xfe\xfd",
        b"h 1",
        b"H",
        b"w\x00",
        b"j " + b"9" * 3000,
        b"x" * 100_000,
        b"u nan",
        b"u -1",
    ]
)
lines = weighted((80, grammar), (10, noise), (5, odd), (1, st.just(b"h")))  # a hold empties the row: seldom
stored = weighted(
    (9, st.sampled_from("jklgdW").flatmap(line_of)), (1, st.sampled_from(["R 2", "E", "#", "", "w", "#" * 190, "h"])),
    (1, st.text(max_size=20).map(lambda t: t.replace("\n", " "))),
).map(lambda text: text.encode())  # fmt: skip
right = st.lists(posture("j").map(lambda v: f"j {v}".encode()), min_size=1, max_size=4)
uploads = st.tuples(st.sampled_from(NUMBERS[2:]), st.one_of(right, st.lists(stored, max_size=8)))
items = weighted((19, lines), (1, uploads))
endings = weighted((8, st.just("stay")), *((1, st.just(how)) for how in ("reset", "half", "upload", "newer", "typed")))


class Fuzz(Watched):
    """The controller under fuzz: one connection after the other, and what its programs must be."""

    def __init__(self, sim):
        super().__init__(sim)
        self.programs, self.epoch, self.ends = dict(PROGRAMS), 1, 0
        self.connect()

    def connect(self):
        host, _, port = (self.sim.folder / "tty").read_text().strip().partition(":")
        self.socket = socket.create_connection((host, int(port)), timeout=ANSWER_S)
        self.rest = b""
        self.epoch += 1
        self.socket.sendall(f"i {self.epoch}\n".encode())
        assert self.hear(1, 10) == [f"ok epoch {self.epoch}".encode()]

    def hear(self, count, seconds=ANSWER_S):
        """Return so many answers, or as many as came in time."""
        heard, until = [], time.monotonic() + seconds
        while len(heard) < count and time.monotonic() < until:
            *whole, self.rest = self.rest.split(b"\n")
            heard += whole
            if len(heard) >= count:
                break
            self.socket.settimeout(max(0.01, until - time.monotonic()))
            with contextlib.suppress(TimeoutError):
                data = self.socket.recv(65536)
                assert data, "the controller closed the line"
                self.rest += data
        return heard

    def play(self, round_of_items, cuts, ending):
        """Say one round, wait for its answers, end the connection as told."""
        out, wanted, waits = b"b\n", 1, 0
        for item in round_of_items:
            if isinstance(item, tuple):
                number, text = item
                out += b"u %d\n%s.\n" % (number, b"".join(line + b"\n" for line in text))
                wanted += 1 + sum(line.split() == [b"h"] for line in text)
                self._expect(number, text)
            else:
                out += item + b"\n"
                wanted += 1
                waits += item.split() == [b"W"]
        for piece in pieces(out, cuts):
            self.socket.sendall(piece)
        heard = self.hear(wanted - waits)
        self.socket.sendall(b"h\n")
        heard += self.hear(wanted + 1 - len(heard))
        self.tried += len(round_of_items) + 2
        self.unanswered += abs(wanted + 1 - len(heard))
        wrong = [one for one in heard if not one.startswith((b"ok ", b"e ", b"s ")) and one not in (b"a", b"b", b"e")]
        assert not wrong, wrong[:3]
        assert not self.unanswered, (wanted, len(heard), heard[-5:])
        for one in heard:
            if one.startswith(b"ok epoch "):
                self.epoch = max(self.epoch, int(one.split()[-1]))
        getattr(self, ending)()

    def _expect(self, number, text):
        """Note what the program of that number must be now: the new one whole, or the old one."""
        shown = [line.decode("ascii", "replace").rstrip("\r") for line in text if line.split() != [b"h"]]
        if all(line.isascii() and line.replace("\t", " ").isprintable() for line in shown):
            with contextlib.suppress(Malformed):
                program("\n".join(shown))
                self.programs[number] = "\n".join(shown)

    def stay(self):
        """Go on."""

    def _gone(self):
        self.ends += 1
        self.socket.close()
        self.connect()

    def reset(self):
        """End the connection hard, in motion."""
        self.socket.sendall(b"j 30 25 75 0 80 0 0.1\nJ 9 0 0 0 0 0\np 1\n")
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self._gone()

    def half(self):
        """End it in the middle of a line."""
        self.socket.sendall(b"j 0 0 0 0 0")
        self._gone()

    def upload(self):
        """End it in the middle of an upload."""
        self.socket.sendall(b"u 2\ng 0\nj 1 2")
        self._gone()

    def newer(self):
        """Let a newer owner take the place."""
        old = self.socket
        self.ends += 1
        self.connect()
        old.close()

    def typed(self):
        """Another one who types is turned away."""
        host, port = self.socket.getpeername()
        with socket.create_connection((host, port), timeout=10) as other:
            other.sendall(b"w\n")
            assert other.recv(100).startswith(b"e busy another client")

    def judge(self):
        """Fail if anything was harmed."""
        self.assert_well()
        status = self.sim.status()
        assert np.all(np.isfinite(status["reference"]))
        assert status["counts"].get("crash", 0) == 0, "a line ended in an error of the controller's own"
        assert status["mode"] != "RANGE_ERROR"
        assert status["nearest"][0] > 0, f"the arm was inside {status['nearest'][1]}"
        assert status["boot"] == 1
        kept = json.loads((self.sim.folder / "programs.json").read_text())
        assert {int(n): text for n, text in kept.items()} == self.programs, "stored programs are whole, old or new"


@pytest.mark.parametrize("part", [0, *(at_length(n) for n in range(1, PARTS))])
def test_promise_44_a_hostile_wire_client_changes_nothing(request, tmp_path, part):
    proof = Proof.at(request.node)
    number = proof.count("lines and pieces of rubbish, museum arm", 500 if part == 0 else 400, 100_000 // PARTS)
    sim = ArmSimulator(tmp_path, watchdog=600, nobody=600)  # a crowded machine makes the fuzzer itself slow
    fuzz = Fuzz(sim)

    @seed(part)
    @settings(rounds(-(-number // (A_ROUND + 2))), derandomize=False)
    @given(st.lists(items, min_size=A_ROUND, max_size=A_ROUND), st.lists(st.integers(0, 4000), max_size=3), endings)
    def play(round_of_items, cuts, ending):
        fuzz.play(round_of_items, cuts, ending)

    try:
        play()
        fuzz.judge()
        assert fuzz.tried >= number * 0.9
        motions = sim.count("motion")
        assert motions > number / 100, "it moved, so that there was something to spoil"
        proof.holds(f"{fuzz.figure()}; {motions} motions, {fuzz.ends} connections cut, 0 stored programs damaged")
    finally:
        fuzz.socket.close()
        sim.stop()
