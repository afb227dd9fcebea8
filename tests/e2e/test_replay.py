"""A recording in the browser: play, move in time by mouse and keyboard, jump to a command; two widths, both schemes."""

import re
from dataclasses import replace

import pytest
from playwright.sync_api import expect

from robots.kit.clock import SYSTEM
from robots.kit.recording.container import Tape
from robots.kit.recording.reading import messages
from robots.models import Movie
from robots.recordings import keeping
from tests.conftest import wait_for
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.recorded import grey
from tests.e2e.recorded import recording as recording
from tests.e2e.test_axe import EACH_LOOK, looked_at, seen
from tests.e2e.test_narrow_console import CUT

pytestmark = pytest.mark.timed

# how bright the middle of the picture is
GREY = "() => { const c = document.getElementById('picture'); return c.getContext('2d').getImageData(90, 80, 1, 1).data[0]; }"


def shows(page, second):
    """Wait until picture and readings are of a second."""
    page.wait_for_selector("#picture")  # the page may be on its way
    wait_for(lambda: abs(page.evaluate(GREY) - grey(second)) < 6, 15, f"the picture of second {second}")
    expect(page.locator("#replay-time")).to_contain_text(f"0:{second:02} of 0:23")


def test_a_recording_is_played_and_moved_in_time_by_mouse_and_keyboard(portal, visitor, recording):
    one = visitor()
    page = one.page
    sent = []
    page.on("websocket", lambda socket: sent.append(socket.url))
    page.goto(recording.turn.get_absolute_url())
    page.get_by_role("link", name="Replay").click()
    shows(page, 0)
    for wide in (320, 390, 600, 735):
        page.set_viewport_size({"width": wide, "height": 844})
        assert page.evaluate("document.documentElement.scrollWidth") <= wide
        assert page.evaluate(CUT, ".robot-head h1, .robot-head .pill, .simulated") == []
    page.set_viewport_size({"width": 1280, "height": 860})
    play, bar = page.locator("#replay-play"), page.locator("#replay-at")
    play.click()
    expect(play).to_have_text("Pause")
    wait_for(lambda: page.evaluate(GREY) > grey(2) - 6, 15, "the picture of second 2, or a later one")
    play.click()
    expect(play).to_have_text("Play")
    second = int(page.inner_text("#replay-time")[2:4])
    assert 2 <= second < 8
    shows(page, second)
    page.locator("#replay-list button", has_text="Failed").click()
    shows(page, 8)
    expect(page.locator("#ladder li").first).to_have_attribute("data-state", "failed")
    expect(page.locator("#ladder")).to_contain_text("It slipped.")
    bar.focus()
    page.keyboard.press("End")
    shows(page, 23)
    page.keyboard.press("Home")  # back: what was not yet given is not listed
    shows(page, 0)
    expect(page.locator("#ladder li")).to_have_count(0)
    for _ in range(12):
        page.keyboard.press("ArrowRight")
    shows(page, 6)
    assert bar.get_attribute("aria-valuetext") == "0:06 of 0:23"
    expect(page.locator("#ladder li").first).to_have_attribute("data-state", "queued")
    for _ in range(4):
        page.keyboard.press("ArrowLeft")
    shows(page, 4)  # a little back, too
    bar.fill("17000")
    shows(page, 17)
    bar.fill("14000")
    shows(page, 14)
    page.locator("#replay-speed").select_option("8")
    play.click()
    shows(page, 23)
    expect(play).to_have_text("Play")
    assert not [url for url in sent if "/ws/robots/" in url], "nothing is asked of the robot itself"


def test_nothing_can_be_commanded_from_a_recording(portal, visitor, recording):
    operator = session(visitor(), recording.turn.user)
    portal.drive(recording.turn.user, "mercury")  # even by somebody who drives the robot now
    page = operator.page
    page.goto(recording.get_absolute_url())
    shows(page, 0)
    expect(page.locator("#controls")).to_be_hidden()
    expect(page.locator("[data-command=stop]")).to_be_hidden()
    page.locator("#screen").click(position={"x": 50, "y": 50})
    page.locator("#screen").press("s")
    shows(page, 0)
    from robots.models import Command

    assert not Command.objects.exists()


@EACH_LOOK
def test_the_page_of_a_recording_for_everybody(portal, visitor, recording, looks):
    one = visitor(**looks[0])
    page = one.page
    page.goto(recording.get_absolute_url())
    expect(page.locator("#replay-time")).to_contain_text("0:23")
    seen(one, looks)
    boxes = page.locator("#replay button, #replay select, #replay input, #replay-list button").evaluate_all(
        "(all) => all.map((e) => e.getBoundingClientRect()).map((b) => Math.min(b.width, b.height))"
    )
    assert min(boxes) >= 24
    looked_at(one, ["/robots/mercury/recordings/"], looks)


def test_on_a_slow_line_it_says_that_it_loads(portal, visitor, recording):
    one = visitor()
    page = one.page
    held = []
    page.route("**/2.bin", lambda route: held.append(route))
    page.goto(recording.get_absolute_url())
    shows(page, 0)
    expect(page.locator("#replay-said")).to_be_empty()
    page.locator("#replay-at").fill("12000")
    expect(page.locator("#replay-said")).to_have_text("Loading…")
    held[0].continue_()
    shows(page, 12)
    expect(page.locator("#replay-said")).to_be_empty()


@pytest.mark.parametrize("wrong", ["#at=", "#at=-3", "#at=1e9", "#at=<b>", "#at=9999999999"])
def test_an_address_names_the_moment_with_which_it_begins(portal, visitor, recording, wrong):
    """The page of a turn links each command to its moment."""
    page = visitor().page
    page.goto(f"{recording.get_absolute_url()}#at=12.0")
    shows(page, 12)
    page.goto(f"{recording.get_absolute_url()}#at=17.0")  # only the fragment changes: the page stays
    shows(page, 17)
    page.goto("/log/")
    page.goto(recording.get_absolute_url() + wrong)
    shows(page, 0)


def test_without_its_slices_the_page_says_so_and_tries_again(portal, visitor, recording):
    one = visitor()
    one.allowed = ("503", "net::")
    page = one.page
    page.route("**/3.bin", lambda route: route.fulfill(status=503, body=""))
    page.goto(recording.get_absolute_url())
    shows(page, 0)
    page.locator("#replay-at").fill("17000")
    expect(page.locator("#replay-said")).to_contain_text("could not be read")
    page.unroute("**/3.bin")
    page.locator("#replay-at").fill("17500")
    shows(page, 17)
    expect(page.locator("#replay-said")).to_be_empty()


def test_the_keyboard_plays_and_moves_wherever_the_focus_is(portal, visitor, recording):
    page = visitor().page
    page.goto(recording.get_absolute_url())
    shows(page, 0)
    play, bar = page.locator("#replay-play"), page.locator("#replay-at")
    bar.focus()
    page.keyboard.press("Space")
    expect(play).to_have_text("Pause")
    page.keyboard.press("Space")
    expect(play).to_have_text("Play")
    page.keyboard.press("End")
    shows(page, 23)
    page.keyboard.press("Home")
    shows(page, 0)
    for _ in range(4):
        page.keyboard.press("ArrowRight")
    shows(page, 2)
    expect(play).to_have_text("Play")
    page.evaluate("() => { window.texts = []; new MutationObserver(() => texts.push(document.getElementById('replay-play').textContent))"
                  ".observe(document.getElementById('replay-play'), { childList: true, characterData: true, subtree: true }); }")  # fmt: skip
    play.focus()
    for key, text in (("Space", "Pause"), ("Enter", "Play")):
        page.keyboard.press(key)
        expect(play).to_have_text(text)
    assert page.evaluate("texts") == ["Pause", "Play"], "each press counts once"


def test_a_recording_that_was_cut_off_plays_to_there_and_says_why_it_ends(portal, visitor, recording):
    path = keeping.path_of(recording)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    page = visitor().page
    page.goto(recording.get_absolute_url())
    expect(page.locator("#replay-end")).to_have_text(re.compile(r"It ends at 0:1\d\. The file was cut off here\."))
    expect(page.locator("#replay-list")).to_contain_text("The file was cut off here.")
    bar = page.locator("#replay-at")
    bar.focus()
    page.keyboard.press("End")
    wait_for(lambda: page.evaluate(GREY) > grey(9) - 6, 15, "the last picture")
    path.unlink()
    recording.version += 1
    recording.save()
    other = visitor()
    other.allowed = ("404",)
    other.page.goto(recording.get_absolute_url())
    expect(other.page.locator("#replay-said")).to_contain_text("is gone")


@pytest.mark.parametrize("hours", [24, -24])
def test_a_recording_during_which_the_time_of_day_was_set_plays_through(portal, visitor, recording, hours):
    path = keeping.path_of(recording)
    new = Tape(path.with_suffix(".other"), {})
    began = int(recording.began_at.timestamp() * 1000)
    for message in list(messages(path)):
        late = message.at_ns >= (began + 12_000) * 10**6
        new.copy(replace(message, at_ns=message.at_ns + late * hours * 3600 * 10**9))
    new.close()
    path.with_suffix(".other").replace(path)
    page = visitor().page
    page.goto(recording.get_absolute_url())
    shows(page, 0)
    expect(page.locator("#replay-list")).to_contain_text(
        f"The time of day was set {'ahead' if hours > 0 else 'back'} by about 1 day here."
    )
    expect(page.locator("#replay-end")).to_be_hidden()
    page.locator("#replay-speed").select_option("8")
    page.locator("#replay-play").click()
    wait_for(lambda: page.evaluate(GREY) > grey(22) - 6, 30, "the last picture")


def test_a_movie_arrives_by_itself_with_its_progress_and_a_failure_offers_again(portal, visitor, recording):
    page = visitor().page
    page.goto(recording.get_absolute_url())
    page.get_by_role("button", name="Make a movie as MP4").click()
    movies = page.locator("#movies")
    expect(movies).to_contain_text("A movie as MP4 (H.264) is being made.")
    page.evaluate("() => { window.stayed = true; }")
    expect(page.locator("#replay-at")).to_be_enabled()
    page.locator("#replay-at").focus()
    bar = movies.get_by_role("progressbar", name="The movie as MP4 (H.264)")
    Movie.objects.update(state=Movie.State.MAKING, progress=40)
    expect(bar).to_have_attribute("value", "40", timeout=20_000)
    expect(movies).to_contain_text("40 %")
    Movie.objects.update(state=Movie.State.FAILED, reason="It has no pictures.")
    expect(movies.get_by_role("button", name="Try again")).to_be_visible(timeout=20_000)
    expect(movies).to_contain_text("could not be made. It has no pictures.")
    assert page.evaluate("stayed && document.activeElement.id") == "replay-at"
    movies.get_by_role("button", name="Try again").click()
    expect(movies).to_contain_text("is being made")
    page.evaluate("() => { window.stayed = true; }")
    movie = Movie.objects.get()
    keeping.movie_path(movie).parent.mkdir(parents=True, exist_ok=True)
    keeping.movie_path(movie).write_bytes(b"movie")
    Movie.objects.update(state=Movie.State.READY, size=5, ready_at=SYSTEM.now())
    expect(movies.get_by_role("link", name="Movie as MP4")).to_be_visible(timeout=20_000)
    assert page.evaluate("stayed"), "without a reload"
