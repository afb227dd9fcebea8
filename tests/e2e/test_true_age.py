"""From the simulated camera's exposure to the pixels on a page: the true age of a picture, beside the age shown."""

import contextlib
import time

import pytest
from playwright.sync_api import expect

from simulators.common import stamp
from tests.conftest import at_length
from tests.crowd import MANY, Crowd
from tests.faults.witness import STALLED, Witness
from tests.rig import Web

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

# Reads the stamp from the pixels each time that the page has drawn; [true age in ms, age by the picture's own time, when] each.
SAMPLE = """async ({seconds, cell, columns, rows}) => {
  const canvas = document.getElementById("picture"), seen = [], end = performance.now() + seconds * 1000;
  let last = -1;
  while (performance.now() < end) {
    await new Promise(requestAnimationFrame);
    const {data} = canvas.getContext("2d").getImageData(0, 0, cell * columns, cell * rows), now = Date.now();
    let number = 0;
    for (let row = 0; row < rows; row++)
      for (let column = 0; column < columns; column++) {
        const at = 4 * ((row * cell + cell / 2) * cell * columns + column * cell + cell / 2);
        number = number * 2 + (data[at + 1] > 127 ? 1 : 0);
      }
    const time = number >>> 8;
    if ((number & 255) !== ((time >> 8) ^ (time & 255) ^ 0xa5) || time === last) continue;
    last = time;
    seen.push([(now - time) & 0xffff, now - Number(canvas.dataset.at), now]);
  }
  return seen;
}"""

LONG_S = 0.2


@pytest.mark.parametrize("viewers", [1, at_length(100), at_length(1000)])
def test_promise_49_the_age_shown_is_the_true_age(portal, visitor, proof, viewers):
    seconds = proof.count("seconds of watching", 6, 20)
    page = visitor().page
    web = Web(**MANY)
    portal.sim.fault("cam_stamp")
    witness = Witness()
    try:
        with Crowd(web.url, viewers - 1, seconds + 60) if viewers > 1 else contextlib.nullcontext() as crowd:
            if crowd:
                crowd.begin()
            page.goto(f"{web.url}/robots/mercury/")
            expect(page.locator("#age")).to_contain_text("a second")
            page.wait_for_timeout(1000)
            seen = page.evaluate(
                SAMPLE, {"seconds": seconds, "cell": stamp.CELL, "columns": stamp.COLUMNS, "rows": stamp.ROWS}
            )
    finally:
        witness.stop()
        portal.sim.clear()
        page.close()  # it would miss the web process
        web.kill()
    true = sorted(age for age, _, _ in seen)
    assert len(true) > seconds, true
    # where the machine stood still while a picture was on its way, nobody measured anything
    since = time.time() - time.monotonic()
    stalls = [(1000 * (a + since), 1000 * (b + since)) for a, b in witness.stalls if b - a > LONG_S]
    beside = [abs(age - shown) for age, shown, now in seen if not any(a < now and b > now - age for a, b in stalls)]
    assert len(beside) > seconds / 2, (seen, stalls)
    assert max(beside) < 500, seen  # the page's own word, from the time at which the owner took the picture
    assert true[len(true) // 2] < 1500, true
    proof.discards(len(seen) - len(beside), STALLED)
    proof.holds(f"{viewers} watching: {len(true)} pictures, {true[len(true) // 2]} ms old when seen, at most {true[-1]} ms; "
                f"the age shown was at most {max(beside)} ms wrong")  # fmt: skip
