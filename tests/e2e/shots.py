"""Take the screenshots of README and docs from a running portal: `make shots`."""

import sys
from pathlib import Path

from benchmarks.command_round_trip import _cookie
from benchmarks.stage import cast, database, set_up


def main() -> None:
    set_up()
    with database():
        _take(Path(sys.argv[1]))


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
                key, _, value = _cookie(person).partition("=")
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
