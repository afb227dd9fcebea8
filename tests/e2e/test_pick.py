"""Pick and put in a real browser: a newcomer stacks two blocks by clicks in a picture; no number is typed."""

import re
import time

import pytest
from playwright.sync_api import expect

from robots.models import Command
from tests.conftest import wait_for

# drawing in three dimensions without a graphics card takes a core of its own
# ruff: noqa: TID251 - its tests are timed
pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["pa10"], indirect=True)]
MOST_S = 120.0  # for two blocks on each other
# Where the picture has the most of a colour: red, green, blue, each at least or at most so many grey levels.
SEEN = """([low, high]) => {
  const canvas = document.querySelector("#picture"), { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
  let n = 0, x = 0, y = 0;
  for (let i = 0; i < width * height; i++)
    if ([0, 1, 2].every((k) => data[4 * i + k] >= low[k] && data[4 * i + k] <= high[k])) {
      n++; x += i % width; y += Math.floor(i / width);
    }
  return n > 20 ? [(x / n + 0.5) / width, (y / n + 0.5) / height] : null;
}"""
RED, YELLOW = ((100, 0, 0), (255, 75, 70)), ((140, 105, 0), (255, 255, 75))


@pytest.fixture
def operator(visitor):
    def make(name="ada", **options):
        person = visitor(**options).cleared(name)
        person.take_turn()
        return person

    return make


def objects(portal):
    return portal.sim.status()["objects"]


def look_at(page, camera):
    """Choose a camera, and wait for its picture."""
    page.click(f"[data-name={camera}]")
    wait_for(
        lambda: page.wait_for_timeout(50) or seen(page, YELLOW) or seen(page, RED), 20, "the picture of the camera"
    )


def seen(page, colour):
    """Return where a block of that colour is in the picture, as somebody sees it (shares of width and height)."""
    return page.evaluate(SEEN, [list(end) for end in colour])


def click(page, colour):
    where = []
    wait_for(lambda: page.wait_for_timeout(50) or where.append(seen(page, colour)) or where[-1], 20, "the block")
    boxes = [page.locator("#screen").bounding_box()]
    wait_for(lambda: page.wait_for_timeout(300) or boxes.append(page.locator("#screen").bounding_box()) or boxes[-1] == boxes[-2], 20, "a picture that keeps its size")  # fmt: skip
    box = boxes[-1]
    page.locator("#screen").click(position={"x": where[-1][0] * box["width"], "y": where[-1][1] * box["height"]})


def go(person):
    """Press Go once the way is shown."""
    expect(person.page.locator("#pick-said")).to_contain_text("Press Go.", timeout=10_000)
    person.press("go-pick")


def test_a_newcomer_stacks_two_blocks_by_clicks_in_less_than_two_minutes(transactional_db, portal, operator):
    ada = operator()
    page, began = ada.page, time.monotonic()
    expect(page.locator("#pick-said")).to_contain_text("Click on what to pick up.")
    look_at(page, "table")
    click(page, RED)
    expect(page.locator("#pick-said")).to_contain_text(
        re.compile(r"The object red, 500 mm ahead of the base, 160 mm to its left, seen \d+ s ago\.")
    )
    assert not Command.objects.exists(), "the way is shown first"
    expect(page.locator("[data-command=put-here]")).to_have_attribute("aria-disabled", "true")
    go(ada)
    expect(page.locator("#pick-said")).to_contain_text("The gripper holds red.")
    expect(page.locator("#grip-said")).to_have_text("Holds red")
    click(page, YELLOW)
    go(ada)
    expect(page.locator("#grip-said")).to_have_text("Empty, open")
    took = time.monotonic() - began
    red, yellow = objects(portal)["red"], objects(portal)["yellow"]
    assert red[2] == pytest.approx(0.06, abs=0.004)
    assert red[:2] == pytest.approx(yellow[:2], abs=0.01)
    assert [one.kind for one in Command.objects.order_by("pk")] == ["pick", "put"]
    assert took < MOST_S
    ada.axe("pick and put")


@pytest.mark.parametrize(
    "look", [{"viewport": {"width": 390, "height": 844}, "has_touch": True, "color_scheme": "dark"}]
)
def test_by_keyboard_and_by_touch_and_where_nothing_lies(transactional_db, portal, operator, look):
    ada = operator(**look)
    page = ada.page
    look_at(page, "table")
    for name in ("pick-here", "put-here", "go-pick"):
        assert page.locator(f"[data-command={name}]").bounding_box()["height"] >= 44
    # the cross begins in the middle of the picture, on the table; arrow keys move it
    page.focus("#screen")
    page.keyboard.press("Shift+ArrowUp")
    expect(page.locator("#pick-said")).to_contain_text("ahead of the base")
    said = page.inner_text("#pick-said")
    page.keyboard.press("Shift+ArrowUp")
    expect(page.locator("#pick-said")).not_to_have_text(said)
    box = page.locator("#screen").bounding_box()
    page.touchscreen.tap(box["x"] + 0.25 * box["width"], box["y"] + 0.62 * box["height"])
    expect(page.locator("#pick-said")).to_contain_text("The table,")
    expect(page.locator("#pick-said")).to_contain_text("Press Go.", timeout=10_000)
    page.focus("#screen")
    page.keyboard.press("Enter")
    assert "nothing was there" in ada.ladder("failed", 60)
    expect(page.locator("#pick-said")).to_contain_text("The gripper is empty: nothing was there.")
    # what the arm cannot reach is refused before anything moves, and said in words
    page.touchscreen.tap(box["x"] + 0.02 * box["width"], box["y"] + 0.95 * box["height"])
    expect(page.locator("#pick-said")).to_contain_text("That place is out of reach. Choose another place.")
    expect(page.locator("[data-command=go-pick]")).to_have_attribute("aria-disabled", "true")
    # one of the cameras moves with the gripper: no place is known there
    page.click("[data-name=gripper]")
    page.locator("#screen").click()
    expect(page.locator("#pick-said")).to_contain_text("Choose another camera: ")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    ada.axe("pick and put on a phone")
