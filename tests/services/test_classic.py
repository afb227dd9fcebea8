"""The console without scripts: only for robots that can be drawn, with pictures under unguessable names."""

import re
from importlib.util import find_spec

import pytest

from portal.keep.seeding import add_robot
from robots.kit.clock import SYSTEM
from robots.models import Frame, Robot

pytestmark = [pytest.mark.service, pytest.mark.django_db]

LINK = b'href="/classic/'


def still(robot, number=1):
    return Frame.objects.create(
        robot=robot, taken_at=SYSTEM.now(), file=f"frames/{robot.slug}/{number}.jpg", width=192, height=165,
        pose=[0, 0.42, 0, 0], joints=[0.9, 1.8, 0, 0],
    )  # fmt: skip


def picture_in(page) -> str:
    return re.search(rb'src="(/classic/[^"]+\.gif)"', page.content)[1].decode()


def enter(client, slug):
    return client.get(client.get(f"/classic/{slug}/")["Location"])


@pytest.mark.parametrize("driver", ["mercury", "pa10", "so101", "turntable"])
def test_the_classic_console_is_offered_where_the_robot_can_be_drawn(db, client, installed, driver):
    robot = add_robot(driver)
    still(robot)
    drawn = driver == "mercury"
    if driver != "so101" or find_spec("lerobot"):  # its ordinary page lists what LeRobot's class can do
        page = client.get(f"/robots/{robot.slug}/")
        assert page.status_code == 200
        assert (LINK in page.content) == drawn
    answer = client.get(f"/classic/{robot.slug}/", follow=True)
    if drawn:
        assert answer.status_code == 200
        assert client.get(picture_in(answer))["Content-Type"] == "image/gif"
        return
    for refused in (
        answer,
        client.get(f"/classic/{robot.slug}/x/"),
        client.post(f"/classic/{robot.slug}/x/", {"do": "up"}),
    ):
        assert refused.status_code == 404
        assert b"has no classic console" in refused.content
        assert f'href="/robots/{robot.slug}/"'.encode() in refused.content
    for name in ("0-0", f"{Frame.objects.get().pk}-20260101000000", "x"):
        assert client.get(f"/classic/{robot.slug}/{name}.gif").status_code == 404


def test_a_robot_whose_package_is_gone_has_no_classic_console(robot, client):
    Robot.objects.filter(pk=robot.pk).update(driver="gone")
    assert client.get("/classic/mercury/").status_code == 404


def test_a_picture_has_one_name_a_person_and_keeps_it_until_the_next(robot, people, client):
    still(robot, 1)
    client.force_login(people["ada"])
    first = picture_in(enter(client, "mercury"))
    assert picture_in(enter(client, "mercury")) == first, "a cache answers until the picture changes"
    assert "immutable" in client.get(first)["Cache-Control"]
    assert not re.search(r"20\d\d[01]\d", first), "no time stamp"
    still(robot, 2)
    second = picture_in(enter(client, "mercury"))
    assert second != first
    assert client.get(first).status_code == client.get(second).status_code == 200


@pytest.mark.asvs("8.2.2")
def test_a_picture_is_for_whom_its_name_was_made(robot, people, client):
    kept = still(robot)
    client.force_login(people["ada"])
    mine = picture_in(enter(client, "mercury"))
    stranger = type(client)()
    assert stranger.get(mine).status_code == 404
    theirs = picture_in(enter(stranger, "mercury"))
    assert theirs != mine
    assert stranger.get(theirs).status_code == 200
    stranger.force_login(people["bob"])
    assert stranger.get(mine).status_code == 404
    stem = mine.rpartition("/")[2].removesuffix(".gif")
    head, _, tail = stem.partition("-")
    other = Frame.objects.create(robot=robot, taken_at=SYSTEM.now(), file="frames/other.jpg")
    for guess in (
        f"{other.pk}-{tail}",
        f"{head}-",
        head,
        f"{kept.pk}-{kept.taken_at:%Y%m%d%H%M%S}",
        "0-0",
        "²-x",
        "9" * 5000,
    ):
        assert client.get(f"/classic/mercury/{guess}.gif").status_code == 404, guess


def test_a_name_is_not_used_again_when_a_number_is(robot, client):
    """As after a restored backup: the database counts on from an older picture."""
    old = still(robot, 1)
    name = picture_in(enter(client, "mercury"))
    number = old.pk
    old.delete()
    Frame.objects.create(pk=number, robot=robot, taken_at=SYSTEM.now(), file="frames/mercury/other.jpg")
    assert picture_in(enter(client, "mercury")) != name
    assert client.get(name).status_code == 404


@pytest.mark.asvs("2.2.1")
@pytest.mark.parametrize("value", ["²", "9" * 5000, "-1", "nan", "\x00"])
def test_odd_numbers_of_a_click_are_refused_in_words(robot, people, client, owned, value):
    client.force_login(people["ada"])
    address = client.get("/classic/mercury/")["Location"]
    answer = client.post(address, {"large.x": value, "large.y": "5"}, follow=True)
    if value == "\x00":  # no text at all: refused at the door
        assert answer.status_code == 400
        return
    assert answer.status_code == 200
    assert b"Nothing was pressed" in answer.content
    assert client.post(address, {"do": "move", "x_mm": value, "y_mm": "400"}, follow=True).status_code == 200
