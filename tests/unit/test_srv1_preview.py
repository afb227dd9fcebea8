"""The rover's previews: turns as they are driven, and the place where a mission ends."""

from itertools import pairwise
from math import degrees, pi, remainder, tau

import pytest

from robots.kit.drivers.srv1.checks import MOST, foresee
from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.missions import judge, parse

HERE = (1.0, 1.0, 2.5)


def turned(poses):
    """Return by how much a path turns (degrees, to the left), and its greatest step."""
    steps = [remainder(b[2] - a[2], tau) for a, b in pairwise(poses)]
    return degrees(sum(steps)), max(map(abs, steps))


@pytest.mark.parametrize(
    ("text", "angle"),
    [
        *((f"turn {angle}", angle) for angle in (90, 180, -180, 270, -270, 360, -360, 359.5)),
        ("look around", 360), ("turn 270\nturn -360\nturn 180", 90), ("turn 270\nwait 5\nread\nturn 270", 540),
    ],
)  # fmt: skip
def test_a_turn_is_shown_as_it_is_driven(text, angle):
    found = foresee("mission", {"text": text}, HERE, {})
    whole, step = turned(found.poses)
    assert whole == pytest.approx(angle) and step <= 0.2 + 1e-9
    assert found.poses[-1][:2] == pytest.approx((0.0, 0.0))


def test_a_turn_of_a_command_is_shown_alike():
    assert turned(foresee("turn", {"angle": pi}, HERE, {}).poses)[0] == pytest.approx(180)


@pytest.mark.parametrize("more", range(12))
def test_a_long_path_is_thinned_and_keeps_its_ends(more):
    text = "go East\ngo Door\n" * 14 + "turn 360\n" * more + "turn 90\ngo South\nphotograph\n"
    found = foresee("mission", {"text": text}, (), {})
    legs, _ = judge(parse(text), hall().home)
    assert len(legs) == 28 + more + 3
    x, y, heading = legs[-1].poses[-1]
    assert found.poses[0] == (0.0, 0.0, 0.0)
    assert found.poses[-1] == pytest.approx((x - hall().home[0], y - hall().home[1], heading)), "home looks along x"
    assert found.times[-1] == pytest.approx(found.seconds) and found.times[0] == 0.0
    assert 1000 < len(found.poses) <= MOST and found.steps[-1] == len(legs)
    assert max(abs(remainder(b[2] - a[2], tau)) for a, b in pairwise(found.poses)) < pi / 2
