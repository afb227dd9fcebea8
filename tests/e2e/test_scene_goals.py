"""What can be won in the scene of the virtual reality arm: recorded from the ghost without a line, sent whole, judged."""

import re

import numpy as np
import pytest
from playwright.sync_api import expect

from robots.kit.arms.goals import goals_of
from robots.models import Command, Finding
from tests.e2e.ghost import Keys, drive, place, put_back
from tests.e2e.test_scene import PHONE, WIDE

# drawing in three dimensions without a graphics card takes a core of its own
pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["puma"], indirect=True)]


@pytest.fixture
def operator(visitor):
    def make(**options):
        person = drive(visitor(**options))
        expect(person.page.locator("#goals-list li")).to_have_count(8, timeout=20_000)
        return person

    return make


def test_a_task_is_recorded_by_keys_with_the_line_cut_and_builds_a_part_of_the_figure(
    transactional_db, portal, operator
):
    ada = operator(**WIDE)
    ada.allowed = ("ERR_", "WebSocket")
    page = ada.page
    put_back(ada, *"abcde")
    expect(page.locator("#goals-count")).to_have_text("figure 0 of 5")
    expect(page.locator("#goals-list li").first).to_have_text(
        re.compile(r"a: 2\d\d mm back, 1\d\d mm right, 4 mm up.*")
    )
    page.context.set_offline(True)
    ada.wire.sent.clear()
    page.click("#record")
    expect(page.locator("#record")).to_have_attribute("aria-pressed", "true")
    page.focus("#ghost-handle")
    page.keyboard.press("p")
    expect(page.locator("#record-said")).to_contain_text("Nothing is between the fingers of the ghost")
    keys = Keys(ada)
    keys.go(np.add(place(page), (-34, -254, -380)))
    keys.reach_goal("the grasp of a")
    page.keyboard.press("p")
    expect(page.locator("#record-said")).to_have_text("Recorded: grasp a.")
    keys.move("up", 100)
    page.keyboard.press("m")
    keys.go(np.add(place(page), (-212, -120, -85)))
    keys.reach_goal("its place in the figure")
    page.keyboard.press("p")
    expect(page.locator("#record-list li")).to_have_text(
        ["grasp a", re.compile(r"move [56]\d\d.* -2\d\d.* 11\d.*"), "put a on plate at 2 5"]
    )
    page.keyboard.press("u")
    expect(page.locator("#record-said")).to_have_text("Taken back: put a on plate at 2 5.")
    page.keyboard.press("p")
    lines = page.locator("#record-list li").all_inner_texts()
    page.click("#record-play")
    expect(page.locator("#record-said")).to_have_text("The ghost shows the way from the arm.")
    assert ada.wire.kinds == set(), "nothing is sent while it is recorded"
    page.context.set_offline(False)
    ada.axe("the scene while a task is recorded")
    page.click("#record-edit")
    text = "\n".join(lines)
    expect(page.locator("#task-text")).to_have_value(text)
    expect(page.locator("#task-said")).to_contain_text("Checked with the objects as the arm knows them", timeout=30_000)
    page.click("[data-command=run-task]")
    ada.ladder("completed")
    assert Command.objects.get(kind="task").args == {"text": text}
    page.click("#tab-scene")
    page.click("#record")
    expect(page.locator("#goals-count")).to_have_text("figure 1 of 5")
    expect(page.locator("#goals-list li").first).to_have_text("✓ a: in its place")
    x, y, _ = portal.sim.status()["objects"]["a"]
    assert (x, y) == pytest.approx((0.3882, -0.36), abs=0.001)


def carry(keys, x, y, z):
    """Move the ghost near a place (mm), over everything on the way."""
    here = place(keys.page)
    for at in ((*here[:2], 200), (x, y, 200), (x, y, z)):
        keys.go(at)


def test_the_figure_is_recorded_by_keys_alone_sent_as_one_task_and_won(transactional_db, portal, operator):
    ada = operator(**WIDE)
    page = ada.page
    put_back(ada, *"abcde")
    keys = Keys(ada)
    page.focus("#record")
    page.keyboard.press("Enter")
    for name, first, there in (
        ("a", -240, (388, -360, 14)), ("b", -160, (452, -360, 14)), ("c", -80, (420, -360, 33)),
        ("d", 0, (436, -360, 53)), ("e", 80, (436, -360, 72)),
    ):  # fmt: skip
        carry(keys, 600, first, 20)
        keys.reach_goal(f"the grasp of {name}")
        page.keyboard.press("p")
        expect(page.locator("#record-said")).to_have_text(f"Recorded: grasp {name}.")
        carry(keys, *there[:2], there[2] + 12)
        if name in "de":
            keys.turn(90)
        keys.reach_goal("its place in the figure")
        page.keyboard.press("p")
    lines = page.locator("#record-list li").all_inner_texts()
    assert lines == [
        "grasp a", "put a on plate at 2 5", "grasp b", "put b on plate at 6 5", "grasp c", lines[5],
        "grasp d", "put d on c by 15.9 0 turned 90", "grasp e", "put e on d",
    ]  # fmt: skip
    assert lines[5] in ("put c on a by 31.8 0", "put c on b by -31.8 0")
    page.focus("#record-edit")
    page.keyboard.press("Enter")
    expect(page.locator("#task-said")).to_contain_text("Checked with the objects as the arm knows them", timeout=30_000)
    page.focus("[data-command=run-task]")
    page.keyboard.press("Enter")
    page.click("#tab-scene")
    expect(page.locator("#goals-said")).to_have_text("Won: The figure of five bricks.", timeout=240_000)
    expect(page.locator("#goals-count")).to_have_text("figure 5 of 5")
    there = portal.sim.status()["objects"]
    goal = next(one for one in goals_of("puma") if one.name == "figure")
    for name, pose in goal.parts.items():
        assert there[name] == pytest.approx(pose[:3, 3], abs=0.002), name
    ada.ladder("completed")
    won = Finding.objects.get(text="won: The figure of five bricks")
    assert won.frame is not None
    assert won.command.kind == "task"


def test_the_rod_is_won_once_and_said_once(transactional_db, portal, operator):
    ada = operator(**PHONE)
    page = ada.page
    page.click("#tab-task")
    page.fill("#task-text", "grasp rod\nmove 550 300 340\nmove 550 300 300\nopen\nmove 550 300 420")
    expect(page.locator("#task-said")).to_contain_text("Checked", timeout=30_000)
    page.click("[data-command=run-task]")
    page.click("#tab-scene")
    expect(page.locator("#goals-said")).to_have_text("Won: The rod, lifted from its threads.", timeout=60_000)
    ada.ladder("completed")
    expect(page.locator("#goals-list")).to_contain_text("The rod, lifted from its threads: won at ")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    ada.axe("a goal that is won, on a phone")
    page.reload()
    expect(page.locator("#goals-list")).to_contain_text("won at ", timeout=20_000)
    expect(page.locator("#goals-said")).to_be_empty()


def test_the_model_lies_over_the_picture_of_a_calibrated_camera(transactional_db, portal, operator):
    ada = operator(**PHONE)
    page = ada.page
    page.check("#camera-picture")
    expect(page.locator("#camera-picture-said")).to_have_text("Choose a camera.")
    for name in ("side", "front"):
        page.get_by_role("button", name=f"As camera {name}").click()
        said = page.locator("#camera-picture-said")
        expect(said).to_contain_text(f"The model lies over the picture of camera {name}", timeout=30_000)
        assert page.evaluate("document.querySelector('.model-picture').width") >= 320
    ada.axe("the model over a picture")
    page.get_by_role("button", name="Top", exact=True).click()
    expect(page.locator(".model-picture")).to_have_count(0)
    expect(page.locator("#model")).not_to_have_attribute("data-picture", "")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
