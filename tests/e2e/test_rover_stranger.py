"""A stranger signs up, composes a mission with the line cut, sends it, goes away, and comes back for its movie."""

import re

import pytest
from playwright.sync_api import expect

from accounts.services import load_bank
from portal.keep.seeding import add_robot
from portal.run.processes import recorder_process
from portal.web.recordings.day import movie_of_the_day
from queueing.models import Job
from robots.kit.clock import SYSTEM
from robots.models import Movie, Recording
from robots.models.recordings import OfTheDay
from tests.conftest import wait_for
from tests.e2e.drawn import blocks
from tests.e2e.looks import looks
from tests.e2e.small import SmallPortal
from tests.rig import Child

pytestmark = pytest.mark.timed

MISSION = "read\ngo 2.5 1.4\nphotograph\nturn 90\nread\nphotograph\nsay Here ends the tour.\n"
PLAYED = "(video) => [video.readyState, video.currentTime, video.videoWidth, video.error && video.error.message]"


@pytest.fixture
def portal(transactional_db, redis_server, house):
    robot = add_robot("srv1")
    load_bank(robot)
    made = SmallPortal(robot, ready_s=120)
    spec = recorder_process()
    recorder = Child("recorder", list(spec.argv), **spec.env, FARHAND_RECORDING_FREE_MB="1")
    yield made
    print(*Recording.objects.values(), *Movie.objects.values(), recorder.said()[-2000:], sep="\n")  # with a failure
    recorder.kill()
    made.stop()


def play(page):
    """Press play on the page's movie, and see that it runs; return how wide it is (px)."""
    video = page.locator("video.film")
    expect(video).to_be_visible()
    assert video.evaluate("(video) => video.play().then(() => true)")

    def runs():
        page.wait_for_timeout(100)
        state, at, _, error = video.evaluate(PLAYED)
        assert error is None, error
        return state >= 2 and at > 0.5

    wait_for(runs, 30, "the movie runs")
    video.evaluate("(video) => video.pause()")
    return video.evaluate(PLAYED)[2]


def test_a_stranger_composes_without_a_line_goes_away_and_finds_the_movie(portal, visitor, tmp_path):
    stranger = visitor().sign_up("ada").get_cleared()
    stranger.allowed = ("ERR_INTERNET_DISCONNECTED",)
    page = stranger.page
    expect(page.locator("#readings")).to_contain_text("Battery", timeout=30_000)
    page.locator("#mission summary").click()
    blocks(page)
    page.context.set_offline(True)
    page.fill("#program-text", MISSION)
    expect(page.locator("#mission-steps tbody tr")).to_have_count(7)
    expect(page.locator("#mission-send")).to_have_attribute("aria-disabled", "true")
    page.context.set_offline(False)
    expect(page.locator("#mission-send")).to_have_attribute("aria-disabled", "false", timeout=60_000)
    page.click("#mission-send")
    expect(page.locator("#asked")).to_have_text(re.compile("mission"), timeout=20_000)
    stranger.context.close()
    wait_for(lambda: Job.objects.get().state == "done", 180, "the mission, whose sender has gone")
    wait_for(lambda: Movie.objects.filter(state="ready").exists(), 400, "the movie, which nobody asked for")

    again = visitor()
    back = again.page
    back.goto("/accounts/login/")
    back.fill("[name=login]", "ada")
    back.fill("[name=password]", "correct horse 42")
    back.click("main button[type=submit]")
    back.locator(".messages", has_text="has ended").get_by_role("link").click(timeout=20_000)
    expect(back.locator("#job h1")).to_contain_text("Mission on Hall rover")
    assert play(back) >= 640
    figure = back.locator(".path-figure")
    expect(figure.locator("polyline")).to_have_count(2)
    expect(figure).to_contain_text(re.compile(r"It drove \d\.\d m, from"))
    expect(figure).to_contain_text(re.compile(r"Planned were \d\.\d m; it ended 0\.\d m from where the plan ends"))
    expect(back.locator(".findings img")).to_have_count(2)
    for image in back.locator(".findings img").all():
        image.scroll_into_view_if_needed()
        wait_for(lambda image=image: image.evaluate("(i) => i.complete && i.naturalWidth") > 0, 20, "the picture")
    found = back.locator("#job")
    for told in ("temperature", "humidity", "light", "Here ends the tour."):
        expect(found).to_contain_text(told)
    looks(again, "mission", tmp_path)

    back.set_viewport_size({"width": 1440, "height": 900})
    back.goto("/movie-of-the-day/")
    expect(back.locator("main")).to_contain_text("There is no movie of the day yet.")
    looks(again, "none", tmp_path)
    Recording.objects.update(of_the_day=OfTheDay.PINNED)
    assert movie_of_the_day(SYSTEM.now()) is not None
    back.reload()
    expect(back.locator("main h2")).to_contain_text("Mission")
    assert play(back) >= 640
    looks(again, "day", tmp_path)
    print(f"screenshots: {tmp_path}")
