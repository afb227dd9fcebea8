"""A camera's picture is encoded once for each way of sending, only while somebody wants it, as often as wanted."""

from collections import Counter

import pytest

from robots.bus import RARE_S, SLOW_S, SOME_S, Demand
from workers.media.steps import COARSE_S, Steps

EACH, VIDEO, COARSE_JPEG, COARSE_VIDEO = Demand(), Demand(video=True), Demand(coarse=True), Demand(0, True, True)
SOME, SLOW, RARE = (Demand(every_s=every_s) for every_s in (SOME_S, SLOW_S, RARE_S))
KEY, COARSE_KEY = Demand(video=True, key=True), Demand(0, True, True, key=True)
EVERY_S, SECONDS = 0.05, 10.0
WAYS = ("jpeg", "video", "coarse", "coarse_video")


def made(wanted):
    """Return how many of each are made in `SECONDS`, while the camera could give twenty pictures a second."""
    steps, counted = Steps("rover", 0, None), Counter()
    for n in range(round(SECONDS / EVERY_S)):
        due = steps.due(wanted, n * EVERY_S)
        if any((due.jpeg, due.video, due.coarse, due.coarse_video)):
            note(steps, due, n * EVERY_S)
        counted.update(way for way in WAYS if getattr(due, way))
    return dict(counted)


def note(steps, due, now):
    """Do what `send` does beside sending."""
    sent = []
    steps._publish = lambda *told, **more: sent.append(told)
    steps._video.take = steps._coarse_video.take = lambda *told: sent.append(told)
    steps.send(due, None, (), now)
    assert len(sent) == sum((due.jpeg, due.video, due.coarse, due.coarse_video))


ALL, COARSE, SECONDLY = round(SECONDS / EVERY_S), SECONDS / COARSE_S, SECONDS


@pytest.mark.parametrize(
    ("wanted", "counts"),
    [
        ([], {}),
        ([EACH], {"jpeg": ALL}),
        ([VIDEO], {"video": ALL}),
        ([EACH, VIDEO, SLOW], {"jpeg": ALL, "video": ALL}),
        ([VIDEO, SLOW], {"video": ALL, "jpeg": SECONDLY}),
        ([COARSE_JPEG], {"coarse": COARSE}),
        ([COARSE_VIDEO, COARSE_JPEG], {"coarse": COARSE, "coarse_video": COARSE}),
        ([COARSE_VIDEO, SLOW], {"coarse_video": COARSE, "jpeg": SECONDLY}),
        ([SLOW], {"jpeg": SECONDLY}),
        ([RARE], {"jpeg": SECONDS / RARE_S}),
        ([RARE, SLOW], {"jpeg": SECONDLY}),
        ([SOME, SLOW], {"jpeg": SECONDS / SOME_S}),
        ([SOME, COARSE_JPEG], {"jpeg": SECONDS / SOME_S, "coarse": COARSE}),
        ([KEY, COARSE_KEY], {}),
    ],
    ids=lambda one: "+".join(demand.name for demand in one) or "nothing" if isinstance(one, list) else "",
)
def test_each_way_is_made_as_often_as_somebody_wants_it(wanted, counts):
    found = made(frozenset(wanted))
    assert found.keys() == counts.keys()
    for way, count in counts.items():
        assert abs(found[way] - count) <= 2, way


def test_a_key_picture_that_is_asked_for_is_one_of_the_right_video():
    due = Steps("rover", 0, 8).due(frozenset({VIDEO, COARSE_VIDEO, COARSE_KEY}), 1.0)
    assert (due.key, due.coarse_key) == (False, True)
