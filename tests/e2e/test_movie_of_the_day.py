"""The movie of the day from `manage.py broadcast` by `manage.py edge` to a real browser."""

import os
import subprocess
import sys
from types import SimpleNamespace

import pytest
from playwright.sync_api import expect

from tests.conftest import wait_for
from tests.e2e.conftest import Visitor
from tests.e2e.looks import looks
from tests.environment import ROOT
from tests.services.test_broadcast_network import free_port
from tests.services.test_broadcast_network import group as group
from tests.unit.test_broadcast_served import film

pytestmark = pytest.mark.timed

CODEC = 'video/mp4; codecs="avc1.64000a"'


@pytest.fixture
def run(tmp_path):
    """Start a command of `manage.py`; its output goes to a file, which is returned."""
    processes = []

    def start(name, *args):
        said, key = tmp_path / f"{name}.log", {"FARHAND_BROADCAST_KEY": "a key of the tests, long"}
        command = [sys.executable, "manage.py", name, *args]
        with said.open("wb") as out:
            processes.append(subprocess.Popen(command, cwd=ROOT, stdout=out, stderr=out, env={**os.environ, **key}))
        return said

    yield start
    for process in processes:
        process.terminate()
    for process in processes:
        process.wait(30)


def test_a_browser_plays_the_broadcast_to_its_end(run, group, chromium, tmp_path):
    day, told = film(tmp_path / "day.mp4", 4), f"{group[0]}:{group[1]}"
    origin, edge = free_port(), free_port()
    heard = run("edge", "--group", told, "--origin", f"http://127.0.0.1:{origin}", "--port", str(edge))
    wait_for(lambda: "the movie:" in heard.read_text(), 60, "the edge serves")
    visitor = Visitor(chromium, SimpleNamespace(url=f"http://127.0.0.1:{edge}"))
    try:
        visitor.allowed = ("status of 503",)  # it is asked for before it is here, too
        page = visitor.page
        page.goto("/")
        if not page.evaluate(f"MediaSource.isTypeSupported('{CODEC}')"):
            pytest.skip("this Chromium shows no H.264")
        said = page.locator("[role=status]")
        expect(said).to_have_text(
            "No movie is broadcast now. When there is one, it begins here by itself.", timeout=60_000
        )
        looks(visitor, "none", tmp_path)
        sent = run(
            "broadcast", str(day), "--title", "Rover, 3 June 2026", "--group", told, "--wait", "1", "--port", str(origin)
        )  # fmt: skip
        wait_for(lambda: "any number of edges" in sent.read_text(), 60, "the origin sends")
        expect(page.locator("video")).to_have_js_property("ended", True, timeout=60_000)
        expect(page.locator("#title")).to_have_text("Rover, 3 June 2026")
        shown = page.evaluate("() => { const v = document.querySelector('video'); return [v.videoWidth, v.duration]; }")
        assert shown[0] == 64
        assert shown[1] == pytest.approx(4, abs=1)
        assert said.inner_text() == ""
        looks(visitor, "edge", tmp_path)
        page.goto("/?loop")
        page.evaluate("window.first = true")
        page.wait_for_function("() => !window.first && document.querySelector('video').currentTime > 0", timeout=60_000)
    finally:
        visitor.close()
