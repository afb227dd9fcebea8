"""What is made of a camera's pictures: each way of sending them once, while somebody wants it, as often as wanted."""

from collections import Counter

import pytest

from robots.bus import RARE_S, SOME_S, Wanted
from workers.media.steps import COARSE_S, Steps

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
        (Wanted(), {}),
        (Wanted(each=True), {"jpeg": ALL}),
        (Wanted(video=True), {"video": ALL}),
        (Wanted(each=True, video=True, now_and_then=True), {"jpeg": ALL, "video": ALL}),
        (Wanted(video=True, now_and_then=True), {"video": ALL, "jpeg": SECONDLY}),
        (Wanted(coarse=True), {"coarse": COARSE}),
        (Wanted(coarse_video=True, coarse=True), {"coarse": COARSE, "coarse_video": COARSE}),
        (Wanted(coarse_video=True, now_and_then=True), {"coarse_video": COARSE, "jpeg": SECONDLY}),
        (Wanted(now_and_then=True), {"jpeg": SECONDLY}),
        (Wanted(rarely=True), {"jpeg": SECONDS / RARE_S}),
        (Wanted(rarely=True, now_and_then=True), {"jpeg": SECONDLY}),
        (Wanted(some=True, now_and_then=True), {"jpeg": SECONDS / SOME_S}),
        (Wanted(some=True, coarse=True), {"jpeg": SECONDS / SOME_S, "coarse": COARSE}),
        (Wanted(key=True, coarse_key=True), {}),
    ],
    ids=lambda one: "+".join(f for f in one._fields if getattr(one, f)) or "nothing" if isinstance(one, Wanted) else "",
)
def test_each_way_is_made_as_often_as_somebody_wants_it(wanted, counts):
    found = made(wanted)
    assert found.keys() == counts.keys()
    for way, count in counts.items():
        assert abs(found[way] - count) <= 2, way


def test_a_key_picture_that_is_asked_for_is_one_of_the_right_video():
    due = Steps("rover", 0, 8).due(Wanted(video=True, coarse_video=True, coarse_key=True), 1.0)
    assert (due.key, due.coarse_key) == (False, True)
