"""The rover's page in a browser: its stick steers by degrees, what was driven unseen is dashed, readings have lines."""

import json
import math
import threading
import time
from datetime import timedelta

import pytest
from playwright.sync_api import expect

from portal.keep.seeding import add_robot
from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.kit.contract.session import RobotState
from robots.kit.packets import state_packet
from robots.models import Command, Lease, Robot
from robots.states import Cycle, GrantKind
from tests.conftest import wait_for
from workers.media.streams import Streams

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
PAD = """
window.shaken = [];
window.pad = { axes: [0, 0], connected: true, mapping: "standard", id: "pad", index: 0,
  buttons: Array.from({length: 17}, () => ({pressed: false})),
  vibrationActuator: { playEffect: (kind, told) => { window.shaken.push({ ...told, at: Date.now() }); return Promise.resolve("complete"); } } };
navigator.getGamepads = () => [window.pad];
Object.defineProperty(document, "hasFocus", { value: () => true });
"""
UNSEEN = {"ways": [[[1, 1], [3, 1.5]]], "events": [[20000, "alone", 1, 1], [2000, "expired", 3, 1.5]]}


class RoverRows:
    """The robot's rows as if its owner lived, and a web process. `near`: what infrared sees (m)."""

    def __init__(self, web):
        self.robot = add_robot("srv1")
        Lease.objects.create(robot=self.robot, epoch=1, expires_at=SYSTEM.now() + timedelta(days=9))
        Robot.objects.update(cycle=Cycle.READY)
        self.web, self.url, self.near, self.heard = web, web.url, 0.8, []
        self._over = threading.Event()
        self._threads = [threading.Thread(target=run, daemon=True) for run in (self._tell, self._hear)]
        for thread in self._threads:
            thread.start()

    def _tell(self):
        spec = self.robot.spec()
        streams = Streams(self.robot.slug, spec.streams, SYSTEM)
        streams.take("unseen", json.dumps(UNSEEN).encode(), True)
        number = 0
        while not self._over.wait(0.2):
            number += 1
            streams.publish()
            values = {
                "infrared": self.near, "sonar": 3.0, "spread": 0.1, "battery": 8.0 + 0.1 * math.sin(number),
                "temperature": 21.0, "humidity": 40.0, "light": 50.0, "presence": 0.0, "compass": 90.0, "driven": 7.0,
            }  # fmt: skip
            state = RobotState(time.monotonic(), (), (3.0, 1.5, 0.2), False, True, "", (), (), "resting", values)
            told = spec.named(state)
            packet = state_packet(number, int(time.time() * 1000), state, False, spec.packed(), told)
            bus.publish_state(self.robot.slug, packet)
            bus.publish_compact(self.robot.slug, packet)

    def _hear(self):
        listener = bus.listener().pubsub(ignore_subscribe_messages=True)
        listener.subscribe(bus.held_channel(self.robot.slug))
        while not self._over.is_set():
            message = listener.get_message(timeout=1.0)
            if message and message["type"] == "message":
                self.heard.append(bus.read_keep_alive(message["data"]))
        listener.close()

    def stop(self):
        self._over.set()
        for thread in self._threads:
            thread.join()


@pytest.fixture
def portal(transactional_db, redis_server, house):
    bus.connection().flushall()
    made = RoverRows(house.web_process())
    yield made
    made.stop()


def driving(portal, visitor, **options):
    """Return a visitor whose turn it is, on the rover's page."""
    one = visitor(**options)
    one.page.context.add_init_script(PAD)
    one.cleared("ada", None)
    now = SYSTEM.now()
    Robot.objects.update(cycle=Cycle.OPERATING)
    services.start_grant(portal.robot, GrantKind.TURN, now, one.user, now + timedelta(minutes=10))
    one.page.goto(f"/robots/{portal.robot.slug}/")
    expect(one.page.locator(".stick")).to_have_attribute("aria-disabled", "false", timeout=30_000)
    return one


def middle(page):
    box = page.locator(".stick").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, box["width"] / 2


def newest(portal, seconds, holds):
    """Wait for a keep-alive whose values hold."""
    return wait_for(
        lambda: next((k for k in portal.heard[::-1][:3] if k.held and k.args and holds(k.args)), None),
        seconds,
        "such values",
    )


def test_a_pointer_steers_by_degrees_and_lets_go(portal, visitor):
    page = driving(portal, visitor).page
    page.locator(".stick").scroll_into_view_if_needed()
    x, y, radius = middle(page)
    page.mouse.move(x, y - radius / 2)
    page.mouse.down()
    wait_for(lambda: Command.objects.filter(kind="drive").exists(), 10, "a command")
    newest(portal, 5, lambda args: 0.3 < args["forward"] < 0.6 and args["turn"] == 0)
    page.mouse.move(x - radius, y - radius / 2)
    newest(portal, 5, lambda args: args["turn"] > 0.6 and 0.2 < args["forward"] < 0.6)
    page.mouse.up()
    wait_for(lambda: portal.heard[-1].held is False, 5, "its release")
    assert Command.objects.filter(kind="drive").count() == 1


def test_arrow_keys_steer_together(portal, visitor):
    page = driving(portal, visitor).page
    page.locator(".stick").focus()
    page.keyboard.down("ArrowUp")
    newest(portal, 10, lambda args: args["forward"] == 0.6)
    page.keyboard.down("ArrowLeft")
    newest(portal, 5, lambda args: args["turn"] == 0.6)
    page.keyboard.up("ArrowUp")
    page.keyboard.up("ArrowLeft")
    wait_for(lambda: portal.heard[-1].held is False, 5, "its release")


def test_a_gamepad_steers_by_degrees_and_is_shaken_by_what_is_near(portal, visitor):
    page = driving(portal, visitor).page
    page.wait_for_timeout(200)  # it is seen at rest
    page.evaluate("() => { window.pad.axes = [0, -0.7]; }")
    newest(portal, 10, lambda args: 0.5 < args["forward"] < 0.8)
    assert page.evaluate("() => window.shaken.length") == 0
    portal.near = 0.2
    last = "() => window.shaken.at(-1)?.strongMagnitude ?? 0"
    wait_for(lambda: page.evaluate(last) > 0.5, 10, "its shaking")
    page.uncheck(".feel input")
    page.wait_for_timeout(400)
    count = page.evaluate("() => window.shaken.length")
    page.wait_for_timeout(600)
    assert page.evaluate("() => window.shaken.length") == count, "it can be switched off"
    page.reload()
    expect(page.locator(".feel input")).not_to_be_checked()


@pytest.mark.parametrize("options", [{}, PHONE], ids=["desktop", "phone"])
def test_what_is_drawn_and_said(portal, visitor, options):
    one = driving(portal, visitor, **options)
    page = one.page
    expect(page.locator("#hall .unseen")).to_have_attribute("d", "M 1.000 -1.000 L 3.000 -1.500")
    expect(page.get_by_text("came to rest at the end of its permit")).to_be_attached()
    line = page.locator("#readings .history polyline").nth(3)
    wait_for(lambda: len((line.get_attribute("points") or "").split()) > 1, 15, "a line of more than one point")
    assert page.evaluate("document.documentElement.scrollWidth") <= page.evaluate("window.innerWidth")
    one.axe("the rover while somebody drives")
