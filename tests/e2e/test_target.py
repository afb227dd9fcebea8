"""Who watches sees where the driver sends the robot: a sentence over the view and a mark, until the command has ended."""

import re

import pytest
from playwright.sync_api import expect

from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.contract.compact import Layout
from robots.kit.contract.joint_path import JointPath
from robots.kit.contract.path_packet import BegunPath, encode_path
from robots.kit.contract.target import target_of
from robots.models import Command
from robots.states import CommandState
from tests.conftest import wait_for
from tests.e2e.bare import JOINTS
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.drawn import settle
from tests.e2e.test_steady import SIZES
from workers.commands.rows import advance, finish

HIDDEN = "9999"  # the place of a ring that is not shown
MOTION_S = 60.0
END = (0.8, 0.5, 1.2, 0.1, 1.3, 0.0)


@pytest.fixture
def pages(portal, visitor):
    """Give the pages of who drives a robot and of a stranger who watches."""

    def make(robot, size=(1440, 900), **look):
        viewport = dict(zip(("width", "height"), size, strict=True))
        driver, watcher = visitor(viewport=viewport, **look), visitor(viewport=viewport, **look)
        user = portal.person("ada", robot)
        portal.drive(user, robot)
        session(driver, user)
        address = portal.robots[robot].get_absolute_url()
        for one in (driver, watcher):
            one.page.goto(address)
            expect(one.page.locator("#line-said")).not_to_be_empty(timeout=20_000)
        expect(driver.page.locator("#robot")).to_have_class("operating")
        return driver, watcher

    return make


def begun(portal, robot, before):
    """Begin the newest command as its owner does."""
    wait_for(Command.objects.exists, 10, "the command")
    command = Command.objects.select_related("robot", "grant").latest("pk")
    command.target = target_of(command.robot.spec(), command.kind, command.args, before)
    for state in (CommandState.ACCEPTED, CommandState.SENT, CommandState.ACKNOWLEDGED):
        advance(command, state, SYSTEM.now())
    return command


@SIZES
def test_who_watches_an_arm_over_sand_sees_where_it_goes_and_the_view_stays(portal, pages, size):
    driver, watcher = pages("mercury", size)
    said, ring = watcher.page.locator("#target"), watcher.page.locator("#schematic .ghost-ring")
    view = watcher.page.locator("#stage-view")
    expect(ring).to_have_attribute("cy", HIDDEN)
    settle(watcher.page)
    place = view.bounding_box()
    driver.page.locator("#schematic").press("ArrowRight")
    driver.page.locator("#schematic").press("Enter")
    command = begun(portal, "mercury", {"x": 0.0, "y": 0.42})
    expect(said).to_have_text(command.target["words"])
    expect(said).to_contain_text("right")
    expect(ring).to_have_attribute("cx", re.compile(rf"^{int(1000 * command.args['x'])}\."))
    expect(driver.page.locator("#target")).to_be_empty()
    watcher.axe("who watches a target")
    late = watcher.new_page()
    late.goto(watcher.page.url)
    expect(late.locator("#target")).to_have_text(command.target["words"])
    finish(command, CommandState.COMPLETED, SYSTEM.now())
    for page in (watcher.page, late):
        expect(page.locator("#target")).to_be_empty()
    expect(ring).to_have_attribute("cy", HIDDEN)
    settle(watcher.page)
    assert view.bounding_box() == place


# what lies under the sentence, or beside it: ages of pictures, what the gripper holds, the buttons of the views
COVERED = """() => {
  const said = document.getElementById("target").getBoundingClientRect();
  return [...document.querySelectorAll(".badges span, #stage-view button, #model-said, #model-legend")].filter((e) => {
    const box = e.getBoundingClientRect();
    return e.checkVisibility() && box.width && e.textContent && box.left < said.right - 1 && box.right > said.left + 1
      && box.top < said.bottom - 1 && box.bottom > said.top + 1;
  }).map((e) => e.textContent);
}"""


@SIZES
def test_a_long_sentence_of_where_it_goes_covers_no_other_words_and_little_of_the_view(portal, pages, size):
    robot = "pa10"
    _, watcher = pages(robot, size, locale="de-DE")
    expect(watcher.page.locator("#model canvas")).to_be_visible(timeout=30_000)
    row = portal.robots[robot]
    args = dict(zip(row.spec().joints, END, strict=False))
    grant = row.grants.get(ended_at=None)
    Command.objects.create(
        robot=row, grant=grant, client_seq=1, issued_by=grant.holder, kind="joints", args=args, epoch=1,
        created_at=SYSTEM.now(), deadline=SYSTEM.now(),
    )  # fmt: skip
    begun(portal, robot, None)
    said = watcher.page.locator("#target")
    expect(said).to_contain_text("Gelenke")
    settle(watcher.page)
    if size[0] < 640:
        assert said.bounding_box()["y"] > watcher.page.locator("#screen").bounding_box()["y"] + 60, "below the picture"
    assert watcher.page.evaluate(COVERED) == []
    view, box = watcher.page.locator("#stage-view").bounding_box(), said.bounding_box()
    assert box["width"] * box["height"] < 0.12 * view["width"] * view["height"]
    assert box["height"] <= 60


def test_who_watches_an_arm_in_three_dimensions_sees_where_it_goes(portal, pages):
    _, watcher = pages("pa10")
    robot, model = portal.robots["pa10"], watcher.page.locator("#model")
    expect(watcher.page.locator("#model canvas")).to_be_visible(timeout=30_000)
    grant = robot.grants.get(ended_at=None)
    args = {name: value for name, value in zip(robot.spec().joints, END, strict=False)}
    Command.objects.create(
        robot=robot, grant=grant, client_seq=1, issued_by=grant.holder, kind="joints", args=args, epoch=1,
        created_at=SYSTEM.now(), deadline=SYSTEM.now(),
    )  # fmt: skip
    command = begun(portal, "pa10", None)
    expect(watcher.page.locator("#target")).not_to_be_empty()
    expect(model).not_to_have_attribute("data-goes", "")
    path = JointPath((JOINTS["pa10"][:6], END), MOTION_S)
    packet = encode_path(Layout.of(robot.spec()), BegunPath(command.pk, int(1000 * SYSTEM.now().timestamp()), path))
    bus.publish_path(robot.slug, packet, MOTION_S)
    expect(model).to_have_attribute("data-goes", "")
    late = watcher.new_page()
    late.goto(watcher.page.url)
    expect(late.locator("#model")).to_have_attribute("data-goes", "", timeout=30_000)
    finish(command, CommandState.CANCELLED, SYSTEM.now(), "Stopped.")
    for page in (watcher.page, late):
        expect(page.locator("#model")).not_to_have_attribute("data-goes", "")
        expect(page.locator("#target")).to_be_empty()
