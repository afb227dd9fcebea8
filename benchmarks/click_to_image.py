"""From the click to the new stable image in the browser, over the physical limit of the same move."""

import json
from datetime import timedelta
from typing import Any

from benchmarks.command_round_trip import cookie
from benchmarks.stage import cast, database, median, set_up, tell

MOVES = 30
WATCH = """
() => { const canvas = document.getElementById("picture"); window.seen = { [canvas.dataset.still]: 0 };
  new MutationObserver(() => { const id = canvas.dataset.still;
    if (id && id !== "0" && !(id in window.seen)) window.seen[id] = performance.now(); })
    .observe(canvas, { attributes: true, attributeFilter: ["data-still"] }); }
"""


def main() -> None:
    """Drive thirty moves in a real browser."""
    set_up()
    with database():
        _run()


def _run() -> None:
    from playwright.sync_api import sync_playwright

    from robots import services
    from robots.kit.clock import SYSTEM
    from robots.models import Command, Robot
    from robots.states import Cycle, GrantKind
    from tests.conftest import RedisServer, wait_for
    from tests.rig import Simulator, Web, worker

    redis = RedisServer()
    redis.start()
    robot, person = cast()
    sim = Simulator(robot.rig_dir)
    owner, web = worker(), Web()
    try:
        wait_for(lambda: Robot.objects.get().cycle == Cycle.READY, 60, "the robot")
        now = SYSTEM.now()
        Robot.objects.update(cycle=Cycle.OPERATING)
        services.start_grant(robot, GrantKind.TURN, now, person, now + timedelta(minutes=30))
        with sync_playwright() as playwright:
            times = _drive(playwright, web, person)
        rows = [
            _compare(ms, command, sim.journal())
            for ms, command in zip(times, Command.objects.order_by("id"), strict=True)
        ]
    finally:
        web.kill()
        owner.kill()
        sim.stop()
        redis.stop()
    _report(rows)


def _drive(playwright: Any, web: Any, person: Any) -> list[float]:
    import os

    browser = playwright.chromium.launch(
        executable_path=os.environ["FARHAND_CHROMIUM"], args=["--no-sandbox", "--disable-gpu"]
    )
    context = browser.new_context(base_url=web.url, locale="en-US", viewport={"width": 1280, "height": 860})
    name, _, value = cookie(person).partition("=")
    context.add_cookies([{"name": name, "value": value, "url": web.url}])
    page = context.new_page()
    page.goto("/robots/mercury/")
    page.wait_for_selector(".operating")
    page.evaluate(WATCH)
    box = page.locator("#screen").bounding_box()
    times = []
    for i in range(MOVES):
        _until(
            page,
            "!!document.querySelector('#why').textContent && !/busy|waiting/.test(document.querySelector('#why').textContent)",
        )
        _until(page, "Number(document.querySelector('#picture').dataset.still) > 0")
        share = (0.25, 0.75, 0.5)[i % 3], (0.3, 0.7, 0.45, 0.55)[i % 4]
        page.mouse.click(box["x"] + box["width"] * share[0], box["y"] + box["height"] * share[1])
        _until(page, "document.querySelector('[data-command=go]').getAttribute('aria-disabled') === 'false'")
        page.evaluate("window.known = new Set(Object.keys(window.seen))")
        begun = page.evaluate(
            "() => { const t = performance.now(); document.querySelector('[data-command=go]').click(); return t; }"
        )
        _until(page, "Object.keys(window.seen).some((id) => !window.known.has(id))")
        ended = page.evaluate(
            "Math.min(...Object.entries(window.seen).filter(([id]) => !window.known.has(id)).map(([, t]) => t))"
        )
        times.append(ended - begun)
        page.wait_for_timeout(250)
    browser.close()
    return times


def _until(page: Any, expression: str) -> None:
    """Wait for an expression; the page's CSP forbids Playwright's own polling."""
    for _ in range(1000):
        if page.evaluate(expression):
            return
        page.wait_for_timeout(20)
    said = {name: page.inner_text(name) for name in ("#why", "#notice")} | {
        "still": page.get_attribute("#picture", "data-still")
    }
    raise TimeoutError(f"{expression}: {said}")


def _compare(ms: float, command: Any, journal: list[dict[str, Any]]) -> dict[str, float]:
    from robots.kit.description import load
    from robots.kit.drivers.mercury.protocol import BYTE_S, Reply, move_xyz, pack_end
    from simulators.mercury.__main__ import READOUT_S

    assert command.state == "completed", (command.state, command.reason)
    sent = command.result["sent"]
    at = next(
        i for i, r in enumerate(journal)
        if r["event"] == "motion" and abs(r["target"][0] - sent["x"]) < 1e-4 and abs(r["target"][1] - sent["y"]) < 1e-4 and not r.get("used")
    )  # fmt: skip
    journal[at]["used"] = True
    rest = next(r["t"] for r in journal[at:] if r["event"] == "rest")
    settled = next((r["t"] for r in journal[at:] if r["event"] == "settled"), rest)
    line = (len(move_xyz(1, 0, 0, 0).encode()) + len(pack_end(Reply.DONE, 1, 1, (0, 0, 0, 0)).encode())) * BYTE_S
    exposures = 2 * (float(load("mercury")["camera"]["stability_exposure_s"]) + READOUT_S)
    motion, ringing = rest - journal[at]["t"], max(0.0, settled - rest)
    limit = line + motion + ringing + exposures
    accepted = (command.accepted_at - command.created_at).total_seconds()
    acknowledged = (command.acknowledged_at - command.accepted_at).total_seconds()
    ended = (command.ended_at - command.acknowledged_at).total_seconds()
    return {
        "ratio": ms / 1000 / limit, "total": ms / 1000, "limit": limit, "line": line, "motion": motion, "ringing": ringing,
        "exposures": exposures, "accepted": accepted, "acknowledged": acknowledged, "to_end": ended,
        "tries": command.result["tries"], "stable": float(command.result["stable"]),
    }  # fmt: skip


def _report(rows: list[dict[str, float]]) -> None:
    middle = {key: round(median([r[key] for r in rows]), 3) for key in rows[0]}
    print("median seconds by stage:")
    for key in ("accepted", "acknowledged", "to_end", "total"):
        print(f"  ours   {key:>13}: {middle[key]:.3f}")
    for key in ("line", "motion", "ringing", "exposures", "limit"):
        print(f"  limit  {key:>13}: {middle[key]:.3f}")
    print(json.dumps({"ratios": [round(r["ratio"], 3) for r in rows]}))
    value = middle["ratio"]
    tell("click_to_image", value, "times the physical limit, median of 30 moves", "<= 1.15", value <= 1.15, middle)
