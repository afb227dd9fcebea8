"""Take the screenshots of README and docs from a running portal: `make shots`."""

import sys
from pathlib import Path

from benchmarks.command_round_trip import cookie
from benchmarks.stage import cast, database, set_up


def main() -> None:
    set_up()
    with database():
        _take(Path(sys.argv[1]))
    with database():
        _take_arm(Path(sys.argv[1]))


def _take_arm(folder: Path) -> None:
    """The museum arm's console: a place filled in, the ghost shown."""
    import os
    from datetime import timedelta

    from playwright.sync_api import sync_playwright

    from accounts.models import Clearance, User
    from portal.seeding import add_robot
    from queueing import services as queue
    from robots.clock import SYSTEM
    from robots.models import Robot
    from robots.states import Cycle
    from tests.conftest import RedisServer, wait_for
    from tests.rig import ArmSimulator, Web, worker

    redis = RedisServer()
    redis.start()
    robot = add_robot("pa10")
    person = User.objects.create_user("ada", "ada@example.org", "correct horse 42")
    Clearance.objects.create(user=person, robot=robot, granted_at=SYSTEM.now())
    robot.rig_dir.mkdir(parents=True, exist_ok=True)
    sim = ArmSimulator(robot.rig_dir)
    owner, web = worker(robot.slug), Web()
    try:
        wait_for(lambda: Robot.objects.get().cycle == Cycle.READY, 60, "the robot")
        queue.join(robot, person, SYSTEM.now())
        queue.tick(SYSTEM.now() + timedelta(seconds=1))
        queue.accept(robot, person, SYSTEM.now())
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=os.environ["FARHAND_CHROMIUM"],
                args=[
                    "--no-sandbox",
                    "--disable-gpu-compositing",
                    "--use-angle=swiftshader",
                    "--enable-unsafe-swiftshader",
                ],
            )
            for name, options in (
                ("arm", {"viewport": {"width": 1440, "height": 1150}}),
                ("arm-dark", {"viewport": {"width": 1440, "height": 1150}, "color_scheme": "dark"}),
                ("arm-phone", {"viewport": {"width": 390, "height": 844}}),
            ):
                context = browser.new_context(base_url=web.url, locale="en-US", **options)
                key, _, value = cookie(person).partition("=")
                context.add_cookies([{"name": key, "value": value, "url": web.url}])
                page = context.new_page()
                page.goto(robot.get_absolute_url())
                page.wait_for_selector(".operating")
                page.wait_for_selector("#model canvas")
                page.wait_for_timeout(2500)
                page.click("#tab-position")
                page.click("[data-fill=pose]")
                for field, number in {"x": 560, "y": 50, "z": 120}.items():
                    page.fill(f"#pose-{field}", str(number))
                page.wait_for_timeout(2500)
                page.screenshot(path=folder / f"{name}.png")
                context.close()
            browser.close()
    finally:
        web.kill()
        owner.kill()
        sim.stop()
        redis.stop()


def _take(folder: Path) -> None:
    import os
    from datetime import timedelta

    from playwright.sync_api import sync_playwright

    from queueing import services as queue
    from robots.clock import SYSTEM
    from robots.models import Robot
    from robots.states import Cycle
    from tests.conftest import RedisServer, wait_for
    from tests.rig import Simulator, Web, worker

    folder.mkdir(parents=True, exist_ok=True)
    redis = RedisServer()
    redis.start()
    robot, person = cast()
    sim = Simulator(robot.rig_dir)
    owner, web = worker(), Web()
    try:
        wait_for(lambda: Robot.objects.get().cycle == Cycle.READY, 60, "the robot")
        queue.join(robot, person, SYSTEM.now())
        queue.tick(SYSTEM.now() + timedelta(seconds=1))
        queue.accept(robot, person, SYSTEM.now())
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=os.environ["FARHAND_CHROMIUM"], args=["--no-sandbox"])
            for name, options in (
                ("console", {"viewport": {"width": 1440, "height": 900}}),
                ("console-dark", {"viewport": {"width": 1440, "height": 900}, "color_scheme": "dark"}),
                ("console-phone", {"viewport": {"width": 390, "height": 844}}),
            ):
                context = browser.new_context(base_url=web.url, locale="en-US", **options)
                key, _, value = cookie(person).partition("=")
                context.add_cookies([{"name": key, "value": value, "url": web.url}])
                page = context.new_page()
                page.goto("/robots/mercury/")
                page.wait_for_selector(".operating")
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
                context.close()
            browser.close()
    finally:
        web.kill()
        owner.kill()
        sim.stop()
        redis.stop()


if __name__ == "__main__":
    main()
