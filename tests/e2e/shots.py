"""Take the screenshots of README and docs from a running portal: `make shots`."""

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from pathlib import Path

from benchmarks.command_round_trip import cookie
from benchmarks.stage import cast, database, set_up

CHROMIUM = ["--no-sandbox", "--disable-gpu-compositing", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
DRAWN = 700  # places of a map that shows the maze
PHONE = {"width": 390, "height": 844}


def main() -> None:
    set_up()
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    with database():
        _take_mercury(folder)
    with database():
        _take_admin(folder)
    with database():
        _take_arm(folder)
    with database():
        _take_scene(folder)
    with database():
        _take_irat(folder)
    with database():
        _take_rules(folder)
    with database():
        _take_hall(folder)


def _take_mercury(folder: Path) -> None:
    """Mercury's console with the sand blown about, and the landing page."""
    robot, person = cast()
    for name, page in _looks(robot, person, 900, ("console", "console-dark", "console-phone")):
        page.wait_for_timeout(1200)
        box = page.locator("#screen").bounding_box()
        if name == "console":
            page.click("[data-command=down]")
            page.wait_for_timeout(2500)
            for _ in range(3):
                page.click("[data-command=air]")
                page.wait_for_timeout(1800)
        page.mouse.click(box["x"] + box["width"] * 0.7, box["y"] + box["height"] * 0.3)
        page.wait_for_timeout(600)
        page.screenshot(path=folder / f"{name}.png")
        page.goto("/")
        page.wait_for_timeout(1000)
        page.screenshot(path=folder / f"landing{name.removeprefix('console')}.png")


def _take_admin(folder: Path) -> None:
    """The first page of staff: a robot that is driven and for which somebody waits, and what waits for a decision."""
    from accounts.models import Clearance, User
    from queueing import services as queue
    from robots.kit.clock import SYSTEM
    from robots.models import Incident, Program

    robot, person = cast()
    now = SYSTEM.now()
    User.objects.filter(pk=person.pk).update(is_staff=True, is_superuser=True)
    bob = User.objects.create_user("bob", "bob@example.org", "correct horse 42")
    Clearance.objects.create(user=bob, robot=robot, granted_at=now)
    before = now - timedelta(hours=2)
    Incident.objects.create(robot=robot, at=before, code="stop_failed", text="The stop was not confirmed in time.")
    Program.objects.create(robot=robot, author=bob, name="three holes", text="down", shared=True, changed_at=before)
    for name, page in _looks(robot, person, 900, ("admin", "admin-dark", "admin-phone")):
        queue.join(robot, bob, SYSTEM.now())
        page.goto("/admin/")
        page.wait_for_selector("[data-picture=live]")
        page.wait_for_timeout(1500)
        page.screenshot(path=folder / f"{name}.png")


def _take_arm(folder: Path) -> None:
    """The museum arm's console: a place filled in, the ghost shown."""
    robot, person = _cleared("pa10")
    for name, page in _looks(robot, person, 1150, ("arm", "arm-dark", "arm-phone")):
        page.wait_for_selector("#model canvas")
        page.wait_for_timeout(2500)
        page.click("#tab-position")
        page.click("[data-fill=pose]")
        for field, number in {"x": 560, "y": 50, "z": 120}.items():
            page.fill(f"#pose-{field}", str(number))
        page.wait_for_timeout(2500)
        page.screenshot(path=folder / f"{name}.png")


def _take_scene(folder: Path) -> None:
    """The virtual reality arm: two bricks of the figure stand on the plate, the ghost is at the rod."""
    robot, person = _cleared("puma")
    for name, page in _looks(robot, person, 1150, ("scene", "scene-dark", "scene-phone")):
        page.wait_for_selector("#model canvas")
        page.wait_for_timeout(2500)
        if name == "scene":
            page.click("#tab-task")
            page.wait_for_function("document.getElementById('task-text').value")  # the robot's own comes first
            page.fill("#task-text", "put a on plate at 2 5\nput b on plate at 6 5\nmove ready")
            page.click("[data-command=run-task]")
            page.locator("#ladder li[data-state=completed]").first.wait_for(timeout=120_000)
            page.click("#tab-scene")
        page.select_option("#ghost-step", "2")
        page.focus("#ghost-handle")
        for key in ["ArrowDown"] * 4 + ["ArrowLeft"] * 14 + ["PageDown"] * 5:
            page.keyboard.press(key)
        page.evaluate("document.activeElement.blur(); scrollTo({ top: 0, behavior: 'instant' })")
        page.wait_for_timeout(1500)
        page.screenshot(path=folder / f"{name}.png")


def _cleared(driver: str):
    """Return a robot that was just added, and a person who may drive it."""
    from accounts.models import Clearance, User
    from portal.keep.seeding import add_robot
    from robots.kit.clock import SYSTEM
    from tests.conftest import PASSWORD

    robot = add_robot(driver)
    person = User.objects.create(username="ada", email="ada@example.org", password=PASSWORD)
    Clearance.objects.create(user=person, robot=robot, granted_at=SYSTEM.now())
    return robot, person


def _take_irat(folder: Path) -> None:
    """The iRat's console: a map that it has drawn, two strangers' goals."""
    from playwright.sync_api import sync_playwright

    from portal.keep.seeding import add_robot
    from robots.models import Lease
    from tests.conftest import RedisServer, wait_for
    from tests.e2e.small import SmallPortal

    redis = RedisServer()
    redis.start()
    robot = add_robot("irat")
    portal = SmallPortal(robot, 150)

    def places() -> float:
        return (Lease.objects.get(robot=robot).state or {}).get("values", {}).get("experiences", 0)

    try:
        wait_for(lambda: places() > DRAWN, 600, "a map")
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=os.environ["FARHAND_CHROMIUM"], args=CHROMIUM)
            far = (("irat", 10), ("irat-dark", 4), ("irat-phone", 10))  # far from each other, and none at the dock
            for (name, place), options in zip(far, _options(1180), strict=True):
                page = browser.new_context(base_url=portal.url, locale="en-US", **options).new_page()
                page.goto(robot.get_absolute_url())
                page.locator("#spots button[aria-disabled=false]").first.wait_for()
                page.locator("#spots button").nth(place).press("Enter")
                page.locator("#notice").wait_for(state="visible")
                page.locator("#notice").wait_for(state="hidden")
                page.evaluate("document.activeElement.blur(); scrollTo(0, 0)")
                page.screenshot(path=folder / f"{name}.png")
                page.context.close()
            browser.close()
    finally:
        portal.stop()
        redis.stop()


def _take_rules(folder: Path) -> None:
    """The rover with a mission that is being written; its rules while it patrols, figure 6, one changed, one refused."""
    robot, person = _cleared("srv1")
    for name, page in _looks(robot, person, 1150, ("rover-rules", "rover-rules-dark", "rover-rules-phone")):
        page.click("#mission > summary")
        page.wait_for_timeout(2500)
        page.select_option("#program-list", label="Evening round")
        page.wait_for_timeout(1500)
        page.evaluate("scrollTo({ top: 0, behavior: 'instant' })")
        page.wait_for_function("() => scrollY === 0")
        page.screenshot(path=folder / f"{name.replace('-rules', '')}.png")
        page.click("#mission > summary")
        if name == "rover-rules":
            page.click("[data-command=patrol]")
        page.click("#hall-rules > summary")
        page.wait_for_timeout(4000)
        if name == "rover-rules":
            page.locator(".hall-surface svg").screenshot(path=folder / "rover-surface.png")
        rules = page.locator("#hall-rules-table select")
        rules.nth(24).select_option("2")  # medium
        rules.nth(9).select_option("4")  # very fast, which is refused
        page.wait_for_timeout(600)
        page.evaluate("document.getElementById('stage-bar').style.display = 'none'")  # it would lie over the rules
        page.locator("#hall-rules").screenshot(path=folder / f"{name}.png")


def _take_hall(folder: Path) -> None:
    """The hall in depth with the rover on a mission (figure 7(b)), and the way that it drove over the way planned (8)."""
    from playwright.sync_api import sync_playwright

    from portal.keep.seeding import add_robot
    from portal.run.processes import recorder_process
    from queueing.models import Job, JobState
    from robots.models import Movie
    from tests.conftest import RedisServer, wait_for
    from tests.e2e.small import SmallPortal
    from tests.rig import Child

    redis = RedisServer()
    redis.start()
    robot = add_robot("srv1")
    portal = SmallPortal(robot, 120)
    spec = recorder_process()
    recorder = Child("recorder", list(spec.argv), **spec.env, FARHAND_RECORDING_FREE_MB="1")
    try:
        job = _mission(robot)
        wait_for(lambda: Job.objects.get(pk=job.pk).state == JobState.RUNNING, 120, "the mission")
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=os.environ["FARHAND_CHROMIUM"], args=CHROMIUM)
            page = browser.new_context(base_url=portal.url, locale="en-US", **_options(1150)[0]).new_page()
            page.goto(robot.get_absolute_url())
            page.click("#deep")
            page.locator("#hall-3d canvas").wait_for()
            page.locator("#readings").get_by_text(re.compile("^within")).wait_for(
                timeout=120_000
            )  # it has found its place,
            page.wait_for_timeout(12_000)  # and drives
            page.locator("#hall-3d").screenshot(path=folder / "rover-hall.png")
            wait_for(lambda: Job.objects.get(pk=job.pk).state == JobState.DONE, 400, "its end")
            wait_for(lambda: Movie.objects.filter(state=Movie.State.READY).exists(), 300, "its movie")
            page.goto(job.get_absolute_url())
            page.locator(".path-figure svg").screenshot(path=folder / "rover-path.png")
            browser.close()
    finally:
        recorder.kill()
        portal.stop()
        redis.stop()


def _mission(robot):
    """Return a job that looks around, and photographs at three places of the hall."""
    from accounts.models import Clearance, User
    from queueing.services import Asker, ask
    from robots.kit.clock import SYSTEM
    from tests.conftest import PASSWORD

    person = User.objects.create(username="ada", email="ada@example.org", password=PASSWORD)
    Clearance.objects.create(user=person, robot=robot, granted_at=SYSTEM.now())
    text = "look around\ngo North-west\nphotograph\ngo Between cases\nphotograph\ngo East\nread\nphotograph\n"
    return ask(robot, Asker(user=person), "mission", {"text": text}, SYSTEM.now())


def _options(height: int) -> tuple[dict[str, object], ...]:
    """Return a large page in the light, one in the dark, and a phone's."""
    large = {"width": 1440, "height": height}
    return {"viewport": large}, {"viewport": large, "color_scheme": "dark"}, {"viewport": PHONE}


def _looks(
    robot, person, height: int, names: tuple[str, str, str], locale: str = "en-US"
) -> Iterator[tuple[str, object]]:
    """Give the operator's page in the light, in the dark and on a phone."""
    from playwright.sync_api import sync_playwright

    from queueing.services import offers_turns

    with _turn(robot, person) as web:
        shown = ".operating" if offers_turns(robot) else "#asking"
        key, _, value = cookie(person).partition("=")  # inside a browser's loop Django opens another connection
        session = {"name": key, "value": value, "url": web.url}
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=os.environ["FARHAND_CHROMIUM"], args=CHROMIUM)
            for name, options in zip(names, _options(height), strict=True):
                context = browser.new_context(base_url=web.url, locale=locale, **options)
                context.add_cookies([session])
                page = context.new_page()
                page.goto(robot.get_absolute_url())
                page.wait_for_selector(shown)
                yield name, page
                context.close()
            browser.close()


@contextmanager
def _turn(robot, person) -> Iterator[object]:
    """Let the person drive the robot, in a portal of its own."""
    from queueing import services as queue
    from robots.kit.clock import SYSTEM
    from robots.models import Robot
    from robots.states import Cycle
    from tests.conftest import RedisServer, wait_for
    from tests.faults.wishes import ROBOTS
    from tests.rig import Web, worker

    redis = RedisServer()
    redis.start()
    robot.rig_dir.mkdir(parents=True, exist_ok=True)
    sim = ROBOTS[robot.driver].simulator(robot.rig_dir)
    owner, web = worker(robot.slug), Web()
    try:
        wait_for(lambda: Robot.objects.get().cycle == Cycle.READY, 60, "the robot")
        if queue.offers_turns(robot):
            queue.join(robot, person, SYSTEM.now())
            queue.tick(SYSTEM.now() + timedelta(seconds=1))
            queue.accept(robot, person, SYSTEM.now())
        yield web
    finally:
        web.kill()
        owner.kill()
        sim.stop()
        redis.stop()


if __name__ == "__main__":
    main()
