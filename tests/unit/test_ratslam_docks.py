"""Places from where the dock was seen: which is tried first, and how false ones go."""

import math

import pytest

from robots.kit.slam.docks import DockPlaces
from robots.kit.slam.experiences import ExperienceMap
from robots.kit.slam.settings import MapSettings


def seen(*sightings):
    docks = DockPlaces()
    for experience, times, z, theta in sightings:
        for _ in range(times):
            docks.saw(experience, z, theta)
    return docks


def test_a_place_seen_often_from_straight_ahead_and_near_is_first():
    docks = seen((1, 1, 0.3, 0.0), (2, 5, 0.9, 0.1), (3, 5, 0.5, 0.2), (4, 9, 0.4, 1.0))
    tried = []
    while (place := docks.best(tried)) is not None:
        tried.append(place)
    assert tried == [3, 2, 4, 1]


def test_a_place_without_a_dock_is_forgotten_until_it_is_seen_again():
    docks = seen((1, 4, 0.3, 0.0), (2, 1, 0.3, 0.0))
    docks.forget(1)
    docks.forget(77)
    assert docks.best() == 2
    docks.forget(2)
    assert docks.best() is None


def test_the_sighting_nearest_to_the_axis_is_kept():
    docks = seen((1, 1, 0.8, 0.6), (1, 1, 0.5, -0.1), (1, 1, 0.3, 0.4))
    assert (docks.places[1].times, docks.places[1].z, docks.places[1].theta) == (3, 0.5, -0.1)


def test_before_the_first_experience_nothing_is_remembered():
    assert seen((-1, 3, 0.5, 0.0)).best() is None


@pytest.mark.parametrize(("z", "theta"), [(math.nan, 0.0), (1e308, 0.0), (-1.0, 0.0), (0.5, math.nan), (0.5, 1e308)])
def test_what_no_camera_sees_is_refused(z, theta):
    with pytest.raises(ValueError, match="must lie between"):
        DockPlaces().saw(1, z, theta)


def test_sightings_go_to_the_one_that_stays_in_the_place_of_one_that_was_pruned():
    docks = seen((1, 2, 0.5, 0.3), (2, 1, 0.4, -0.1), (3, 4, 0.6, 0.2))
    docks.inherit({1: 7, 2: 3, 5: 6})
    assert set(docks.places) == {7, 3}
    assert (docks.places[7].times, docks.places[7].theta) == (2, 0.3)
    assert (docks.places[3].times, docks.places[3].z, docks.places[3].theta) == (5, 0.4, -0.1)


def test_where_the_dock_is_follows_from_a_few_sightings_from_near():
    held = ExperienceMap(MapSettings())
    held.create(0, (0.0, 0.0, 0.0))  # faces up the page
    for n in range(1, 6):
        held.move(0.1, 0.0, 1.0)
        held.create(n, (0.0, 0.0, 0.0))
    docks = seen((0, 3, 0.9, 0.0), (3, 1, 0.55, 0.0), (4, 2, 0.45, 0.0), (77, 2, 0.3, 0.0))
    assert docks.where(held, 0.07) is None
    docks.saw(5, 0.35, 0.1)
    assert docks.where(held, 0.07) == pytest.approx((0.0, 0.92), abs=0.01)
