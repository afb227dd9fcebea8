"""How many frames a second a page draws of an arm in three dimensions, without a graphics card, while its view is turned."""

import os
import time
from typing import Any

LASTS_S, SETTLES_S = 5, 3
# the view draws each frame onto a cleared canvas, in one pass
COUNT = """
window.frames_drawn = 0;
const clear = WebGL2RenderingContext.prototype.clear;
let last = -1;
WebGL2RenderingContext.prototype.clear = function (...all) {
  const now = document.timeline.currentTime;
  if (now !== last) [last, window.frames_drawn] = [now, window.frames_drawn + 1];
  return clear.apply(this, all);
};
"""
RESIZE = """
([width, height]) => { const { style } = document.getElementById("model");
  for (const [name, value] of Object.entries({ width, height })) style.setProperty(name, `${value}px`, "important");
  for (const name of ["max-width", "border"]) style.setProperty(name, "none", "important");
  style.setProperty("min-height", "0", "important"); }
"""


def frames_a_second(address: str, width: int, height: int) -> float:
    """Return the frames a second of the view of a robot's page, at that size (CSS pixels)."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=os.environ["FARHAND_CHROMIUM"], args=["--no-sandbox", "--disable-gpu-compositing"]
        )
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.add_init_script(COUNT)
        page.goto(address)
        page.wait_for_selector("#model canvas")
        page.evaluate(RESIZE, [width, height])
        page.wait_for_timeout(1000 * SETTLES_S)
        box = page.locator("#model canvas").bounding_box()
        if (box["width"], box["height"]) != (width, height):
            raise RuntimeError(f"the view is not {width} x {height}: {box}")
        found = _turn(page, box)
        browser.close()
        return round(found, 1)


def _turn(page: Any, box: Any) -> float:
    """Turn the view by the mouse; return the frames a second."""
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 4
    page.mouse.move(x, y)
    page.mouse.down()
    before, began, n = page.evaluate("frames_drawn"), time.monotonic(), 0
    while time.monotonic() - began < LASTS_S:
        n += 1
        page.mouse.move(x + 3 * n % 150, y + n % 50)
    drawn = page.evaluate("frames_drawn") - before
    page.mouse.up()
    return float(drawn / (time.monotonic() - began))
