"""The museum arm's console in a real browser: blocks put on others by position mode and by a program."""

import io
import re
import time

import numpy as np
import pytest
from django.conf import settings
from PIL import Image
from playwright.sync_api import expect

from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import OutOfWorkspace
from robots.kit.contract.values import check
from robots.kit.description import programs_of
from robots.models import Command, Program, Robot
from tests.conftest import wait_for
from tests.e2e.conftest import session
from tests.e2e.drawn import blocks
from tests.looked import swept

CORNERS = ("from x", "from y", "from z", "to x", "to y", "to z")

# drawing in three dimensions without a graphics card takes a core of its own
# ruff: noqa: TID251 - its tests are timed
pytestmark = [pytest.mark.timed, pytest.mark.parametrize("which", ["pa10"], indirect=True)]


@pytest.fixture
def operator(visitor):
    def make(name="ada", **options):
        person = visitor(**options).cleared(name)
        person.take_turn()
        return person

    return make


def place(person, x, y, z, straight=False):
    """Fill in a place (mm), see the ghost, go there."""
    page = person.page
    page.set_checked("#straight", straight)
    for name, value in {"x": x, "y": y, "z": z, "roll": 180, "pitch": 0, "yaw": 180}.items():
        page.fill(f"#pose-{name}", str(value))
    expect(page.locator("#model-said")).to_contain_text("s on the way")
    person.press("go-pose")


def run(person):
    """Run the program and see the register say so."""
    page = person.page
    person.give("run")
    try:
        expect(page.locator("#mode")).to_contain_text("PROG EXEC", timeout=20_000)
    except AssertionError as error:
        said = [page.inner_text(f"#{part}") for part in ("ladder", "notice", "why", "mode")]
        raise AssertionError(f"the program runs: not within 20 s: {said}") from error


def objects(portal):
    return portal.sim.status()["objects"]


def test_a_stranger_puts_a_block_on_another_by_position_mode(transactional_db, portal, operator):
    ada = operator()
    page = ada.page
    expect(page.locator("#model canvas")).to_be_visible(timeout=20_000)
    page.click("#tab-position")
    x, y, _ = (round(v * 1000, 1) for v in objects(portal)["blue"])
    gx, gy, _ = (round(v * 1000, 1) for v in objects(portal)["green"])
    # a place in the table is refused where it is typed in, and nothing moves
    page.click("[data-fill=pose]")
    page.fill("#pose-z", "-50")
    expect(page.locator("#model-said")).to_contain_text("the table")
    expect(page.locator("[data-command=go-pose]")).to_have_attribute("aria-disabled", "true")
    assert not Command.objects.exists()
    place(ada, x, y, 150)
    place(ada, x, y, 22, straight=True)
    ada.press("close")
    place(ada, x, y, 150, straight=True)
    assert objects(portal)["blue"][2] > 0.1, "it is lifted"
    place(ada, gx, gy, 150)
    place(ada, gx, gy, 63, straight=True)
    ada.press("open")
    place(ada, gx, gy, 150, straight=True)
    blue, green = objects(portal)["blue"], objects(portal)["green"]
    assert blue[2] == pytest.approx(0.06, abs=0.004)
    assert blue[:2] == pytest.approx(green[:2], abs=0.015)
    # the three cameras show pictures, each its own
    for view in range(3):
        canvas = page.locator(f"[data-view='{view}'] canvas")
        assert int(canvas.get_attribute("data-at")) > time.time() * 1000 - 60_000
    ada.axe("the arm's console")


def test_another_by_a_program_that_is_tried_on_the_ghost_first_then_saved(transactional_db, portal, operator):
    for name, text in programs_of("pa10"):
        Program.objects.create(robot=portal.robot, name=name, text=text, approved=True, changed_at=SYSTEM.now())
    ada = operator()
    page = ada.page
    page.click("#tab-program")
    blocks(page)
    page.select_option("#program-list", label="Red onto yellow")
    expect(page.locator("#program-said")).to_contain_text("no forbidden box is touched")
    expect(page.locator("#model-said")).to_contain_text("The ghost is at step")
    assert not Command.objects.exists(), "the ghost moves, not the arm"
    assert page.locator(".blocklyDraggable").count() >= 9
    run(ada)
    ada.ladder("completed", 90)
    red, yellow = objects(portal)["red"], objects(portal)["yellow"]
    assert red[2] == pytest.approx(0.06, abs=0.004)
    assert red[:2] == pytest.approx(yellow[:2], abs=0.015)
    # a program of one's own: typed, refused with the line, mended, saved, found again
    page.click("[data-program=new]")
    page.fill("#program-text", "g 0\nk 500 160")
    expect(page.locator("#program-said")).to_contain_text("Line 2: k needs 6 or 7 numbers")
    expect(page.locator("[data-command=run]")).to_have_attribute("aria-disabled", "true")
    page.fill("#program-text", "g 0\nk 500 160 -50 180 0 180")
    expect(page.locator("#program-judged")).to_have_text(
        re.compile(r"^Will not run, after 0:0\d min: Step 2: .*the table")
    )
    expect(page.locator("[data-command=run]")).to_have_attribute("aria-disabled", "true")
    page.fill("#program-text", "R 2\nj 10 25 75 0 80 0\nj -10 25 75 0 80 0\nE")
    expect(page.locator("#program-said")).to_contain_text("no forbidden box is touched")
    page.fill("#program-name", "Wave")
    page.check("#program-shared")
    page.click("[data-program=save]")
    expect(page.locator("#program-saved")).to_contain_text("after staff have approved it")
    kept = Program.objects.get(name="Wave")
    assert (kept.author.username, kept.shared, kept.approved) == ("ada", True, False)
    # and broken off by a stop: it does not go on after the release
    run(ada)
    page.click("[data-command=stop]")
    text = ada.ladder("cancelled")
    assert "stopped" in text
    page.check("#checked")
    page.click("[data-command=release]")
    expect(page.locator("#release")).to_be_hidden()
    latch = settings.VAR / "run" / f"{portal.robot.slug}.stopped"
    wait_for(lambda: page.wait_for_timeout(20) or not latch.exists(), 10, "the release")
    before = portal.sim.count("motion")
    swept(portal.robot)
    assert portal.sim.status()["mode"] != "PROG_EXEC"
    assert portal.sim.count("motion") == before
    ada.axe("program mode")


def test_joints_jog_terminal_and_a_target_in_motion(transactional_db, portal, operator):
    ada = operator()
    page = ada.page
    # the sliders begin where the arm is; another target is shown by the ghost, then driven to
    page.click("#tab-joint")
    expect(page.locator("#model-said")).to_have_text("The arm is there")
    page.fill(".joint:nth-child(1) input[type=number]", "20")
    expect(page.locator("#model-said")).to_contain_text("s on the way")
    ada.press("go-joints")
    expect(page.locator("#readings tbody tr").first).to_contain_text("20.0°")
    # hold to turn an axis: it goes on while held and ends when released
    button = page.locator('[data-jog="S1,-1"]')

    def press():
        button.hover()
        page.mouse.down()

    def held():
        start = portal.sim.status()["q"][0]
        ada.hold_until(
            button, press, page.mouse.up, lambda: portal.sim.status()["q"][0] < start - 0.1, "the axis turns"
        )
        page.mouse.up()

    ada.lets_go(held)
    # a newer target takes the place of the one before, in motion
    page.fill("#speed", "10")
    page.fill(".joint:nth-child(1) input[type=number]", "80")
    ada.give("go-joints")
    wait_for(lambda: page.wait_for_timeout(20) or portal.sim.status()["moving"], 10, "the motion")
    page.wait_for_timeout(500)
    page.fill(".joint:nth-child(1) input[type=number]", "0")
    ada.give("go-joints")
    ada.ladder("completed", 40)
    newer, older = Command.objects.filter(kind="joints").order_by("-pk")[:2]
    assert (older.state, older.reason[:8], newer.state) == ("cancelled", "Replaced", "completed")
    assert portal.sim.status()["q"][0] == pytest.approx(0.0, abs=0.01)
    # the terminal goes through the same checks
    page.click("#tab-terminal")
    expect(page.locator("#why")).to_be_empty()
    for line, answer in (
        ("j 1 2", "needs 6 or 7"),
        ("j 0 25 75 0 80 400", "e The arm cannot go there: joint W2"),
        ("g 1", "ok"),
        ("w", "a"),
        ("x", "There is no command"),
    ):
        page.fill("#terminal-line", line)
        page.keyboard.press("Enter")
        expect(page.locator("#terminal-said .answer").last).to_contain_text(answer, timeout=20_000)
    ada.axe("terminal")


def test_a_turn_that_is_known_before_the_first_state(transactional_db, portal, operator):
    page = operator().page
    known = []

    def pass_on(socket):
        server = socket.connect_to_server()
        server.on_message(lambda message: socket.send(message) if known or isinstance(message, str) else None)

    page.route_web_socket(re.compile("/ws/"), pass_on)
    page.reload()
    page.wait_for_selector(".operating")
    expect(page.locator("#model canvas")).to_be_visible(timeout=20_000)
    page.wait_for_timeout(1000)  # it asks where a target leads after 0.12 s
    assert page.inner_text("#model-said") == ""
    assert page.input_value("#pose-x") == ""
    known.append(True)
    expect(page.locator("#model-said")).to_have_text("The ghost is at the arm")
    page.click("#tab-joint")
    expect(page.locator("#model-said")).to_have_text("The arm is there")
    expect(page.locator("#pose-x")).not_to_have_value("")


@pytest.mark.parametrize("look", [{"viewport": {"width": 390, "height": 844}, "color_scheme": "dark"}])
def test_on_a_phone_and_by_keyboard(transactional_db, portal, operator, look):
    ada = operator(**look)
    page = ada.page
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.focus("#tab-scene")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    expect(page.locator("#tab-position")).to_be_focused()
    expect(page.locator("#panel-position")).to_be_visible()
    page.keyboard.press("Tab")
    page.keyboard.press("ArrowRight")
    expect(page.locator("#speed-said")).to_have_text("55 %")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    ada.axe("phone")
    page.focus("#screen")
    page.keyboard.press("Escape")
    expect(page.locator("#release")).to_be_visible()
    expect(page.locator("#stop-said")).to_have_text("The robot is stopped")


def test_staff_draw_a_box_and_the_controller_refuses_it(portal, visitor, django_user_model):
    django_user_model.objects.create_superuser("root", "root@example.org", "correct horse 42")
    kim = session(visitor(), django_user_model.objects.get(username="root"))
    page = kim.page
    address = f"/admin/robots/robot/{portal.robot.pk}/change/"
    page.goto(address)
    expect(page.locator(".boxes-editor .model canvas")).to_be_visible(timeout=20_000)
    page.click("text=Add a box")
    editor = page.locator(".boxes-editor")
    editor.get_by_label("name").fill("the vase")
    for label, value in zip(CORNERS, (0.4, 0.1, 0.0, 0.6, 0.3, 0.3), strict=True):
        editor.get_by_label(f"{label} (m)").fill(str(value))
    assert '"the vase"' in page.input_value("[name=setting_boxes]")
    kim.axe("box editor")
    page.click("[name=_continue]")
    expect(page.locator(".messagelist")).to_contain_text("was changed successfully")
    vase = {"name": "the vase", "low": [0.4, 0.1, 0.0], "high": [0.6, 0.3, 0.3]}
    assert Robot.objects.get(pk=portal.robot.pk).settings == {"boxes": [vase]}
    expect(editor.get_by_label("name")).to_have_value("the vase")
    wait_for(lambda: any(r["extra"] == ["the vase"] for r in portal.sim.journal() if r["event"] == "boxes"), 30, "the controller is told")  # fmt: skip
    with pytest.raises(OutOfWorkspace, match="the vase"):
        check("pa10", "pose", {"x": 0.5, "y": 0.2, "z": 0.15, "roll": 3.14, "pitch": 0, "yaw": 3.14}, {"boxes": [vase]})  # fmt: skip
    # nonsense is named, and nothing of what was written is lost
    page.fill("[name=setting_boxes]", '[{"name": "", "low": [0, 0, 0], "high": [1, 1, 1]}]')
    page.click("[name=_continue]")
    expect(page.locator(".errorlist")).to_contain_text("name")
    assert '"high": [1, 1, 1]' in page.input_value("[name=setting_boxes]")
    page.goto(address)
    page.click("text=Remove the vase")
    page.click("[name=_continue]")
    wait_for(lambda: [r["extra"] for r in portal.sim.journal() if r["event"] == "boxes"][-1] == [], 30, "it is told again")  # fmt: skip


def test_the_view_comes_nearer_by_buttons_and_by_the_wheel_with_control(portal, visitor):
    one = visitor()
    page = one.page
    page.goto("/robots/pa10/")
    canvas = page.locator("#model canvas")
    expect(canvas).to_be_visible(timeout=20_000)
    page.wait_for_timeout(1500)

    def look():
        page.wait_for_timeout(900)  # few frames are drawn without a graphics card
        return np.asarray(Image.open(io.BytesIO(canvas.screenshot(caret="initial"))).convert("L"), dtype=float)

    def change(one, other):
        return np.mean(np.abs(one - other) > 20)

    def nearer():
        wait_for(lambda: change(look(), whole) > 0.02, 15, "a nearer view")

    seen = [look()]
    wait_for(lambda: seen.append(look()) or change(*seen[-2:]) == 0, 30, "a view that is drawn")
    whole = seen[-1]
    page.click("[aria-label=Nearer]")
    nearer()
    page.click("[aria-label='All of the arm']")
    wait_for(lambda: change(look(), whole) < 0.005, 15, "the view of all")
    top = page.evaluate("scrollY")
    canvas.hover()
    page.keyboard.down("Control")
    page.mouse.wheel(0, -200)
    page.keyboard.up("Control")
    nearer()
    assert page.evaluate("scrollY") == top


def test_a_stranger_stacks_blocks_by_a_task_that_names_them(transactional_db, portal, operator):
    """The task is tried on the ghost with the blocks as they lie, runs line by line, and is refused where it cannot be."""
    for name, text in programs_of("pa10", "task"):
        Program.objects.create(
            robot=portal.robot, name=name, text=text, approved=True, changed_at=SYSTEM.now(), kind="task"
        )
    ada = operator()
    page = ada.page
    page.click("#tab-task")
    blocks(page, "#task-blocks")
    page.select_option("#task-list", label="Tower of three")
    expect(page.locator("#task-said")).to_contain_text("Checked with the objects")
    expect(page.locator("#model-said")).to_contain_text("The ghost is at step")
    assert page.locator("#task-blocks .blocklyDraggable").count() >= 4
    page.fill("#task-text", "grasp red\ngrasp blue")
    expect(page.locator("#task-judged")).to_contain_text("Line 2, grasp blue: the gripper holds red already.")
    expect(page.locator("[data-command=run-task]")).to_have_attribute("aria-disabled", "true")
    page.fill("#task-text", "put red on yellow\nput red")
    expect(page.locator("#task-said")).to_contain_text("Line 2: allowed: put A on B")
    assert not Command.objects.exists(), "the ghost moves, not the arm"
    page.fill("#task-text", "put red on yellow\nput blue on red\nexpect blue on red")
    expect(page.locator("#task-said")).to_contain_text("Checked with the objects")
    ada.give("run-task")
    ada.ladder("completed", 90)
    there = objects(portal)
    assert there["blue"][2] == pytest.approx(0.10, abs=0.004)
    assert there["blue"][:2] == pytest.approx(there["yellow"][:2], abs=0.015)
    page.fill("#task-text", "grasp yellow")
    expect(page.locator("#task-judged")).to_contain_text("Line 1, grasp yellow: red lies on yellow.")
    ada.axe("the arm's console with a task")
