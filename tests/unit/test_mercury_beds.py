"""Where the pieces of a simulated bed lie, and what the simulator remembers of a bed that is made anew."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.contract.excavation import Excavation
from robots.kit.contract.find import spec_of
from robots.kit.description import load
from robots.kit.drivers.mercury import protocol as wire
from robots.kit.drivers.mercury.beds import FIRST, MOST_BEDS, places
from robots.kit.drivers.mercury.checks import check_target
from robots.kit.drivers.mercury.pieces import pieces
from robots.kit.drivers.mercury.protocol import Error, Instruction, Reply
from simulators.mercury.__main__ import Simulator
from simulators.mercury.artifacts import ARTIFACTS
from simulators.mercury.sand import COVER_MM, X0_MM, Y0_MM
from tests.unit.sand_beds import fresh

secrets, numbers = st.text(min_size=1, max_size=64), st.integers(1, MOST_BEDS)


def test_every_object_has_a_place():
    assert {one.name for one in ARTIFACTS} == FIRST.keys()
    assert places("", 1) == FIRST


@given(secrets, numbers)
def test_all_pieces_lie_apart_where_the_nozzle_reaches_them(secret, number):
    hidden = pieces(secret, number)
    assert {one.name for one in hidden} == FIRST.keys()
    x0, y0, x1, y1 = spec_of("mercury").capability(Excavation).area
    for one in hidden:
        assert x0 < one.x < x1
        assert y0 < one.y < y1
        check_target(load("mercury"), one.x, one.y, 0.0)
    assert min(np.hypot(a.x - b.x, a.y - b.y) for a in hidden for b in hidden if a is not b) > 0.06


@given(secrets, secrets, numbers, numbers)
def test_another_secret_or_number_has_other_places(secret, other, number, another):
    mine = set(places(secret, number).values())
    assert mine == set(places(secret, number).values()), "they are the same at each start"
    assert secret == other or not mine & set(places(other, number).values())
    assert number == another or not mine & set(places(secret, another).values())


@settings(deadline=None, max_examples=2)
@given(secrets, st.integers(1, 50))
def test_in_each_bed_everything_is_buried_where_the_register_says(secret, number):
    bed = fresh(1, places(secret, number))
    assert not ((bed.sand - bed.rigid < COVER_MM * 0.3) & (bed.rigid > 0)).any()
    for one in pieces(secret, number):
        r, c = int(one.y * 1000) - Y0_MM, int(one.x * 1000) - X0_MM
        assert (bed.rigid[r - 4 : r + 5, c - 4 : c + 5] > 0).mean() > 0.25, one.name


@pytest.fixture
def begun(tmp_path):
    """Begin the simulator of the folder, as a new process of it would; `bury` waits for the bed."""

    every = []

    class Begun(Simulator):
        def __init__(self, secret=""):
            super().__init__(tmp_path, 1, lambda *_: None, bed=fresh, secret=secret)
            self.said, self.seq = [], 0
            every.append(self)

        def bury(self, number):
            self.seq += 1
            self.controller.handle(wire.scalar(Instruction.BURY, self.seq, number), self.said.append)
            if self._sand is not None:
                self._sand.join()
            return self.said[-1]

        @property
        def hidden(self):
            return json.loads((tmp_path / "pieces.json").read_text())

    yield Begun
    for one in every:
        one.journal.close()
    for one in tmp_path.iterdir():
        assert not one.name.endswith(".part")


def laid_bare(bed):
    return bool(((bed.sand - bed.rigid < COVER_MM) & (bed.rigid > 0)).any())


def dug(sim):
    """Lay the watch bare, and store the sand."""
    x, y = sim.hidden["places"]["watch"]
    for _ in range(6):
        sim.bed.blow(x, y, 0.5)
    sim._blow(x, y, 0.1)
    sim._sand.join()
    assert laid_bare(sim.bed)


def test_after_bury_the_sand_is_flat_the_places_are_new_and_a_restart_has_both(begun):
    sim = begun("a secret")
    assert sim.hidden == {"number": 1, "places": {n: list(xy) for n, xy in places("a secret", 1).items()}}
    dug(sim)
    assert sim.bury(2).id == Reply.ACK
    assert np.array_equal(sim.bed.sand, fresh(2, places("a secret", 2)).sand), "nobody has dug there"
    assert not laid_bare(sim.bed)
    assert sim.hidden == {"number": 2, "places": {n: list(xy) for n, xy in places("a secret", 2).items()}}
    dug(sim)
    for secret in ("a secret", "another", ""):
        again = begun(secret)
        assert np.allclose(again.bed.sand, sim.bed.sand)
        assert np.array_equal(again.bed.rigid, sim.bed.rigid), "a bed that was made keeps its places"
    assert again.bury(1).id == Reply.ACK, "the same number is no way back"
    assert again.hidden["places"] == {n: list(xy) for n, xy in FIRST.items()}


@pytest.mark.parametrize("number", [0.0, -1.0, 2.5, float(MOST_BEDS + 1), float("nan")])
def test_a_number_of_no_bed_is_refused(begun, number):
    sim = begun()
    answer = sim.bury(number)
    assert (answer.id, wire.unpack_nak(answer.payload)[1]) == (Reply.NAK, Error.OUT_OF_RANGE)
    assert sim.hidden["number"] == 1


def test_a_simulator_that_dies_while_a_bed_is_made_has_that_bed_and_no_sand_that_was_dug(begun, monkeypatch):
    sim = begun("a secret")
    dug(sim)
    monkeypatch.setattr(sim._clock.__class__, "spawn", lambda self, work, name: None)
    sim._sand = None
    sim.bury(2)
    monkeypatch.undo()
    sim._blow(0.0, 420.0, 0.3)  # of the old bed, which is still shown
    sim._sand.join()
    again = begun("a secret")
    assert again.hidden["number"] == 2
    assert np.array_equal(again.bed.sand, fresh(2, places("a secret", 2)).sand)


@pytest.mark.parametrize("text", ["{", "[]", '{"number": 1, "places": {"watch": 3}}'])
def test_places_that_cannot_be_read_make_the_first_bed(begun, tmp_path, text):
    sim = begun("a secret")
    dug(sim)
    (tmp_path / "pieces.json").write_text(text)
    again = begun("a secret")
    assert again.hidden["number"] == 1
    assert not laid_bare(again.bed)


def test_sand_of_before_is_poured_anew_once_where_there_is_a_secret(begun, tmp_path):
    sim = begun()
    dug(sim)
    (tmp_path / "pieces.json").unlink()
    assert laid_bare(begun().bed), "without a secret the places are as they were"
    (tmp_path / "pieces.json").unlink()
    assert not laid_bare(begun("a secret").bed)
    dug(begun("a secret"))
    assert laid_bare(begun("a secret").bed), "but once only"
