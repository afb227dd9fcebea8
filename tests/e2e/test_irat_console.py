"""The iRat's console: strangers without accounts give goals by a click and from the list; staff drive by hand."""

import re
import shutil

import pytest
from django.conf import settings
from playwright.sync_api import expect

from queueing.models import Job
from robots import bus, services
from robots.kit.contract.streams import unpack
from robots.kit.drivers.irat.composites.decoding import MapShown, with_map
from robots.models import Command, Robot
from tests.conftest import wait_for
from tests.e2e.conftest import session
from tests.e2e.roaming import MAP, place_on
from tests.e2e.roaming import portal as portal
from tests.e2e.small import SmallPortal
from tests.rig import Board

pytestmark = pytest.mark.timed

PHONE = {"viewport": {"width": 320, "height": 480}, "has_touch": True, "is_mobile": True, "color_scheme": "dark"}
CLICKS = """() => {
  window.clicks = 0;
  setInterval(() => { window.clicks += 1; document.querySelector("#spots button")?.click(); }, 20);
}"""
WIDTH = "document.documentElement.scrollWidth"
EXPERIENCES, LOOPS = 60, 5


def opened(visitor, **options):
    """Return a stranger on the robot's page, with the map on the screen."""
    one = visitor(**options)
    one.asked_for = []
    one.page.on("request", lambda r: one.asked_for.append(r.url))
    one.page.goto("/robots/irat/")
    expect(one.page.locator("#spots button").first).to_have_attribute("aria-disabled", "false", timeout=30_000)
    return one


def test_two_strangers_one_on_a_phone_give_goals_by_click_and_from_the_list(portal, visitor):
    first, phone = opened(visitor), opened(visitor, **PHONE)
    a, b = first.page, phone.page
    first.allowed = ("429",)  # one guest has one open goal: a browser reports each refusal
    a.locator("#map").click(position=place_on(a, 15))
    expect(a.locator("#asked")).to_have_text(re.compile("Your goal waits. It is next; "))
    expect(a.locator("#notice")).to_have_text(re.compile("Your goal waits. It is next; "))
    asked = Job.objects.get()
    assert (asked.kind, asked.user, asked.state) == ("goal", None, "waiting")
    assert (asked.args["map"], asked.args["experience"]) == (MAP, 15)
    assert (asked.args["x"], asked.args["y"]) == pytest.approx((0.0, 0.8), abs=0.003)
    b.locator("#spots button").first.focus()
    b.keyboard.press("Enter")
    expect(b.locator("#asked")).to_have_text(re.compile("Your goal waits. One is before it; "))
    assert Job.objects.count() == 2
    expect(a.locator("#goals li")).to_have_count(2)
    expect(a.locator("#goals .own")).to_contain_text("(yours)")
    expect(b.locator("#goals .own b")).to_have_text("1")
    a.locator("#map").click(position=place_on(a, 45))
    expect(a.locator("#notice")).to_have_text(
        "You have an open job on this robot; wait until it has ended, or cancel it."
    )
    a.locator("#map").click(position={"x": 3, "y": 3})
    expect(a.locator("#notice")).to_contain_text("knows no place there")
    a.locator("#map").click(position=place_on(a, 30))
    expect(a.locator("#notice")).to_contain_text("This place is at the dock, where the robot goes only to charge.")
    listed = a.locator("#spots button span").all_inner_texts()
    assert "middle right" in listed
    assert "middle left" not in listed, "the dock is there"
    assert Job.objects.count() == 2
    for one in (first, phone):
        one.axe("with a goal that waits")
    for width in (320, 390):
        b.set_viewport_size({"width": width, "height": 480})
        b.wait_for_timeout(150)
        assert b.evaluate(WIDTH) <= width
    assert a.evaluate(WIDTH) <= 1280
    assert a.locator("#cells canvas").count() == 1
    assert not [url for url in phone.asked_for if "cell_grid" in url], "a phone does not load what it does not show"
    for page in (a, b):
        expect(page.locator("[data-command=stop]")).to_be_hidden()
    a.reload()
    expect(a.locator("#asked")).to_have_text(re.compile("Your goal waits. It is next; "), timeout=20_000)
    a.locator("[data-do=cancel]").click()
    expect(a.locator("#asked")).to_contain_text("Your goal was cancelled.")
    expect(b.locator("#asked")).to_contain_text("It is next")
    b.locator("#asked-do a").click()
    expect(b.locator("h1")).to_contain_text("Go to a place on iRat")


def test_staff_drive_by_hand_under_lock_out_and_strangers_see_no_pad(portal, visitor, people):
    stranger = opened(visitor)
    expect(stranger.page.locator("#drive")).to_be_hidden()
    kim = session(visitor(color_scheme="dark"), people["kim"])
    expect(stranger.page.locator("#suspended")).to_be_hidden()
    services.lock_out(portal.robot, people["kim"], "driven by hand")
    expect(stranger.page.locator("#suspended")).to_contain_text("wait until staff press Resume jobs")
    expect(stranger.page.locator("#suspended")).to_be_visible()
    expect(stranger.page.locator("#suspended button")).to_have_count(0)
    robot = Robot.objects.get(pk=portal.robot.pk)
    services.release_stop(robot, people["kim"], True)
    services.start_maintenance(robot, people["kim"])
    kim.page.goto("/robots/irat/")
    button = kim.page.locator("#suspended button")
    expect(button).to_have_attribute("aria-disabled", "false")
    kim.allowed = ("ERR_", "WebSocket")  # what a browser reports without a connection
    kim.context.set_offline(True)
    button.click(force=True)
    expect(kim.page.locator("#notice")).to_contain_text("there is no connection")
    kim.context.set_offline(False)
    expect(kim.page.locator("#drive")).to_be_visible(timeout=20_000)
    expect(kim.page.locator("[data-command=stop]")).to_be_visible()
    forward = kim.page.locator("#drive [data-jog='1,0']")
    expect(forward).to_have_attribute("aria-disabled", "false", timeout=20_000)
    forward.scroll_into_view_if_needed()
    box = forward.bounding_box()
    kim.page.mouse.move(box["x"] + 5, box["y"] + 5)
    kim.page.mouse.down()
    command = wait_for(lambda: Command.objects.filter(kind="drive").first(), 10, "the motion")
    kim.page.mouse.up()
    assert command.args == {"forward": 1, "turn": 0}
    kim.axe("staff drive")
    resume = kim.page.locator("#suspended button")
    expect(resume).to_have_attribute("aria-disabled", "false")
    resume.click()
    expect(kim.page.locator(".messages")).to_contain_text("Jobs and the robot's own behaviour go on.")
    for page in (kim.page, stranger.page):
        expect(page.locator("#suspended")).to_be_hidden()


@pytest.fixture
def alive(transactional_db, redis_server):
    """The robot with its simulator, its owner and its brain, which explores."""
    from portal.keep.seeding import add_robot

    robot = add_robot("irat")
    for folder in (
        robot.rig_dir,
        settings.VAR / "robots" / robot.slug,
    ):  # neither the place nor the map of a test before
        shutil.rmtree(folder, ignore_errors=True)
    made = SmallPortal(robot, 150, FARHAND_TRUSTED_PROXIES="127.0.0.1")  # so that each visitor can have an address
    yield made
    made.stop()


class TestTheRobotItself:
    """With everything that runs in a museum: it draws its map and drives to the goals of strangers."""

    @pytest.fixture
    def portal(self, alive):
        return alive

    def test_strangers_are_served_while_a_third_who_began_first_clicks_as_fast_as_he_can(self, portal, visitor):
        greedy = opened(visitor, **at("203.0.113.9"))
        greedy.allowed = ("429",)
        wait_for(lambda: greedy.page.wait_for_timeout(500) or known(greedy) > EXPERIENCES, 240, "a map")
        greedy.page.evaluate(CLICKS)
        wait_for(lambda: greedy.page.wait_for_timeout(100) or Job.objects.exists(), 60, "the first goal of the third")
        strangers = {
            "198.51.100.7": opened(visitor, **at("198.51.100.7")),
            "192.0.2.5": opened(visitor, **at("192.0.2.5"), **PHONE),
        }
        tries = dict.fromkeys(strangers, 0)

        def served():
            for address, one in strangers.items():
                theirs = Job.objects.filter(account__network=address)
                if theirs.filter(state__in=("waiting", "running", "done")).exists():
                    continue
                assert tries[address] < 3, list(theirs.values_list("state", "reason"))
                one.page.locator("#spots button").nth(tries[address]).press("Enter")
                expect(one.page.locator("#asked")).to_have_text(
                    re.compile("Your goal (waits|was)|on its way to your goal")
                )
                wait_for(lambda n=theirs, more=tries[address]: n.count() > more, 30, "the goal")
                tries[address] += 1
            greedy.page.wait_for_timeout(300)
            return all(Job.objects.filter(account__network=a, state="done").exists() for a in strangers)

        wait_for(served, 600, "both strangers have arrived")
        for one in strangers.values():
            expect(one.page.locator("#asked")).to_contain_text("Your goal was reached.")
        assert greedy.page.evaluate("clicks") > 100
        his = Job.objects.filter(account__network="203.0.113.9")
        assert his.exists()
        for job in Job.objects.filter(account__network__in=strangers):
            begun = his.filter(
                runs__grant__opened_at__gt=job.asked_at,
                runs__grant__opened_at__lt=job.runs.earliest("pk").grant.opened_at,
            )
            assert begun.distinct().count() <= 1, "each of them is next in turn, whatever the third wants"

    def test_a_loop_closes_a_low_battery_is_charged_in_mid_goal_and_staff_clear_the_map(self, portal, visitor, people):
        robot, one = portal.robot, opened(visitor)
        wait_for(lambda: one.page.wait_for_timeout(500) or loops(robot) > LOOPS, 400, "loops that close")
        board = Board(robot.rig_dir)
        for number in range(4):  # a place near where it stands is reached before the battery is told
            one.page.locator("#spots button").nth(number).press("Enter")
            wait_for(
                lambda n=number: one.page.wait_for_timeout(100) or Job.objects.exclude(state="waiting").count() > n,
                400,
                "the turn of the goal",
            )
            one.page.wait_for_timeout(1000)
            if Job.objects.latest("pk").state != "running":
                continue
            board.fault("charge", 0.19)
            expect(one.page.locator("#readings")).to_contain_text("going to the dock", timeout=30_000)
            wait_for(lambda: Job.objects.latest("pk").state != "running", 30, "what the queue makes of that")
            if Job.objects.latest("pk").state == "waiting":
                break
            board.fault("charge", 0.968)
        expect(one.page.locator("#asked")).to_have_text(re.compile("Your goal waits"))
        expect(one.page.locator("#readings")).to_contain_text("charging", timeout=400_000)
        board.fault("charge", 0.968)
        wait_for(
            lambda: one.page.wait_for_timeout(500) or Job.objects.latest("pk").state in ("done", "failed"),
            400,
            "the goal",
        )
        job = Job.objects.latest("pk")
        assert job.runs.count() == 2, "cut short once, then finished"
        expect(one.page.locator("#asked")).to_have_text(re.compile(r"Your goal was (not )?reached\."))
        kim = session(visitor(), people["kim"])
        services.lock_out(robot, people["kim"], "the map")
        robot = Robot.objects.get(pk=robot.pk)
        services.release_stop(robot, people["kim"], True)
        services.start_maintenance(robot, people["kim"])
        kim.page.goto("/robots/irat/")
        before, number, clear = known(one), shown(robot).number, kim.page.locator("[data-command=clear_map]")
        expect(clear).to_have_attribute("aria-disabled", "false", timeout=30_000)
        clear.click()
        wait_for(
            lambda: one.page.wait_for_timeout(200) or known(one) < before / 2, 30, "a new map on a stranger's page"
        )
        assert shown(robot).number == number + 1


def at(address):
    """Return a browser with that address, as a proxy would tell it."""
    return {"extra_http_headers": {"X-Forwarded-For": address}}


def shown(robot):
    """Return the map as a new viewer of the robot would get it."""
    held = MapShown()
    for data in bus.connection().lrange(bus.stream_key(robot.slug, 0), 0, -1):
        packet = unpack(data)
        held = with_map(held, packet.data, packet.key)
    return held


def loops(robot):
    """Return how many links join places that were not made one after the other."""
    links = shown(robot).links
    return int((abs(links[:, 0] - links[:, 1]) > 20).sum())


def known(visitor):
    said = visitor.page.locator("#readings tr", has_text="Remembered places").locator("td").inner_text()
    return int(said) if said.isdigit() else 0
