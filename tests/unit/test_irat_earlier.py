"""The iRat's map before this one: a page can tell why and when it was cleared, and show it, also after a restart."""

import numpy as np

from robots.kit.clock import SYSTEM, ms_of
from robots.kit.drivers.irat.brain.messages import Clear, Key, Packet
from robots.kit.drivers.irat.brain.mind import Mind
from robots.kit.drivers.irat.composites.decoding import MapShown, with_map
from robots.kit.drivers.irat.packets import EARLIER, Why
from tests.irat_trial import explore, explored
from tests.unit.test_irat_brain import walk


def earlier_of(answers):
    found = [one for one in answers if isinstance(one, Packet) and one.stream == "earlier"]
    return found[-1] if found else None


def read(packet):
    """Return why, age (s), when (ms), and the map."""
    version, why, age, at = EARLIER.unpack_from(packet.data)
    assert version == 1 and packet.key
    return Why(why), age, at, with_map(MapShown(), packet.data[EARLIER.size :], True)


def test_a_map_that_was_cleared_is_told_whole(tmp_path):
    mind = Mind(tmp_path)
    walk(mind, 20)
    number, count, places = mind.slam.map_number, mind.slam.map.count, mind.slam.map.poses[: mind.slam.map.count, :2]
    places = places.copy()
    before_ms = ms_of(SYSTEM.now())
    list(mind.take(Clear(1, Why.AGE)))
    answers = walk(mind, 1)
    why, _, at, shown = read(earlier_of(answers))
    assert (why, shown.number, len(shown.ids)) == (Why.AGE, number, count)
    assert np.abs(shown.places - places).max() < 0.01
    assert before_ms <= at <= ms_of(SYSTEM.now())
    assert earlier_of(walk(mind, 1)) is None, "once"
    list(mind.take(Key("earlier")))
    assert earlier_of(walk(mind, 1)) is not None
    assert read(earlier_of(walk(Mind(tmp_path), 1)))[3].number == number, "and again by the next process"


def test_a_map_that_could_not_be_read_is_said_to_be_lost(tmp_path):
    mind = Mind(tmp_path)
    walk(mind, 20)
    mind.save()
    (tmp_path / "map.npz").write_bytes(b"damaged")
    why, _, _, shown = read(earlier_of(walk(Mind(tmp_path), 1)))
    assert (why, shown.number, len(shown.ids)) == (Why.LOST, mind.slam.map_number, 0)


def test_a_first_map_has_none_before_it(tmp_path):
    assert earlier_of(walk(Mind(tmp_path), 2)) is None


def test_a_robot_that_explores_for_long_begins_a_new_map_and_says_why(tmp_path):
    """Seen on the page before: the map was gone after ten minutes or more, and nothing said why."""
    trial = explored(tmp_path)
    trial.roaming._clear_s = 40.0
    explore(trial, 20)
    mind, number = trial.brain.mind, trial.brain.mind.slam.map_number
    trial.roaming.clear_if_due()
    assert mind.slam.map_number == number + 1
    why, age, _, shown = read(Packet("earlier", mind._earlier._packet, True))
    assert why == Why.AGE and age > 40.0 and shown.number == number and len(shown.ids) > 10
