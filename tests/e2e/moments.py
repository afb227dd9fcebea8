"""Screenshots of the moments when something breaks while somebody drives: part of `make shots`."""

import os
import subprocess
import sys
import time  # noqa: TID251 - which of two places comes next
from datetime import timedelta
from pathlib import Path

from benchmarks.command_round_trip import cookie
from benchmarks.stage import cast, database, set_up


def main() -> None:
    """Break one thing after the other, and look."""
    set_up()
    os.environ["FARHAND_MEDIA"] = os.environ["FARHAND_VAR"] + "/small/media"
    small = Path(os.environ["FARHAND_VAR"]) / "small"
    small.mkdir()
    mounted = not subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4m", "none", str(small)], check=False).returncode
    (small / "media").mkdir()
    try:
        with database():
            Moments(Path(sys.argv[1]), small if mounted else None).take()
    finally:
        if mounted:
            subprocess.run(["umount", "-l", str(small)], check=False)


class Moments:
    """One operator at one robot."""

    def __init__(self, folder: Path, small: Path | None) -> None:
        from tests.conftest import RedisServer
        from tests.rig import Simulator, Web, worker

        folder.mkdir(parents=True, exist_ok=True)
        self.folder, self.small = folder, small
        self.redis = RedisServer()
        self.redis.start()
        self.robot, self.person = cast()
        self.sim = Simulator(self.robot.rig_dir)
        self._worker = worker
        self.worker, self.web = worker(), Web()

    def take(self) -> None:
        from playwright.sync_api import sync_playwright

        from queueing import services as queue
        from robots.kit.clock import SYSTEM
        from robots.models import Robot
        from robots.states import Cycle
        from tests.conftest import wait_for

        wait_for(lambda: Robot.objects.get().cycle == Cycle.READY, 60, "the robot")
        queue.join(self.robot, self.person, SYSTEM.now())
        queue.tick(SYSTEM.now() + timedelta(seconds=1))
        queue.accept(self.robot, self.person, SYSTEM.now())
        try:
            with sync_playwright() as playwright:
                browser = playwright.chromium.launch(
                    executable_path=os.environ["FARHAND_CHROMIUM"], args=["--no-sandbox"]
                )
                context = browser.new_context(
                    base_url=self.web.url, locale="en-US", viewport={"width": 1440, "height": 900}
                )
                key, _, value = cookie(self.person).partition("=")
                context.add_cookies([{"name": key, "value": value, "url": self.web.url}])
                self.page = context.new_page()
                self.page.goto("/robots/mercury/")
                self.page.wait_for_selector(".operating")
                self._all()
                browser.close()
        finally:
            self.web.kill()
            self.worker.kill()
            self.sim.stop()
            self.redis.stop()

    def _all(self) -> None:
        from robots.models import Robot
        from tests.conftest import wait_for

        def well():
            self.page.wait_for_timeout(50)
            button = self.page.get_attribute("[data-command=up]", "aria-disabled")
            down = self.page.get_attribute("[data-command=down]", "aria-disabled")
            return "false" in (button, down) and not Robot.objects.get().reason

        self._move()
        self.sim.stop()
        self._shot("cable-pulled", 3.0)
        self.sim.start()
        wait_for(well, 60, "the cable is back")
        self._shot("cable-back", 0.5)
        self._move()
        self.worker.kill()
        self._shot("worker-killed", 4.0)
        self.worker = self._worker()
        wait_for(well, 60, "the worker is back")
        self._shot("worker-back", 0.3)
        self.redis.stop()
        self._shot("redis-gone", 2.5)
        self.redis.start()
        wait_for(well, 60, "Redis is back")
        if self.small is not None:
            with (self.small / "ballast").open("wb") as out:
                try:
                    while True:
                        out.write(os.urandom(65536))
                        out.flush()
                except OSError:
                    pass
            self._move()
            self._shot("disk-full", 4.0)
            (self.small / "ballast").unlink()
        self._move()
        self.page.keyboard.press("Escape")
        self._shot("stopped", 1.5)

    def _move(self) -> None:
        box = self.page.locator("#schematic").bounding_box()
        share = 0.42 if time.monotonic() % 2 < 1 else 0.58
        self.page.mouse.click(box["x"] + box["width"] * share, box["y"] + box["height"] * 0.3)
        self.page.wait_for_timeout(150)
        self.page.click("[data-command=go]")
        self.page.wait_for_timeout(400)

    def _shot(self, name: str, after: float) -> None:
        self.page.wait_for_timeout(after * 1000)
        self.page.evaluate("scrollTo(0, 0)")
        self.page.screenshot(path=self.folder / f"moment-{name}.png")


if __name__ == "__main__":
    main()
