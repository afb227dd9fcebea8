"""Take the pictures of the orientations from running robots, and note where each control is that a text names.

They go into a folder beside each robot's text, `orientation` or `orientation.<language>`. Part of `make shots`.
"""

import io
import json
import sys
from pathlib import Path

from django.conf import settings
from PIL import Image

from accounts.orientation import PLACES, folder_of, orientation
from benchmarks.stage import database, set_up
from tests.e2e.shots import _cleared, _looks

SHIPPED = ("mercury", "pa10", "irat", "srv1", "puma")
AROUND = 22  # px around the controls; a number lies on a corner
LONGEST = 1300  # px; what is farther down on a narrow page is not shown
WEBP = {"format": "WEBP", "quality": 60, "method": 6}
RECTANGLE = """(name) => {
  const shown = (one) => one?.checkVisibility() && one.getBoundingClientRect().width > 0;
  const found = [document.getElementById(name), ...document.querySelectorAll(`[data-command="${name}"]`)].find(shown);
  if (!found) return null;
  const box = found.getBoundingClientRect();
  return [box.x + scrollX, box.y + scrollY, box.width, box.height];
}"""


def main() -> None:
    set_up()
    for driver in sys.argv[1:] or SHIPPED:
        for language in dict(settings.LANGUAGES):
            if orientation(driver, language).language == language:
                with database():
                    _take(driver, language)


def _take(driver: str, language: str) -> None:
    robot, person = _cleared(driver)
    beside = Path("robots/kit/drivers") / driver
    controls = orientation(driver, language).controls
    folder = beside / folder_of(language)
    folder.mkdir(exist_ok=True)
    places = {}
    for width, page in _looks(robot, person, 900, ("wide", "", "narrow"), language):
        if not width:
            continue
        page.wait_for_timeout(3000)
        page.evaluate("document.activeElement.blur(); scrollTo(0, 0)")
        found = {name: box for name in controls if (box := page.evaluate(RECTANGLE, name))}
        missing = set(controls) - set(found)
        first = min(box[1] for box in found.values())
        found = {name: box for name, box in found.items() if box[1] + box[3] - first <= LONGEST}
        if missing:
            raise SystemExit(f"{driver}: the page shows no {', '.join(sorted(missing))} ({width})")
        left, top = (max(0, min(box[i] for box in found.values()) - AROUND) for i in (0, 1))
        right, bottom = (max(box[i] + box[i + 2] for box in found.values()) + AROUND for i in (0, 1))
        clip = {"x": left, "y": top, "width": right - left, "height": bottom - top}
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            page.wait_for_timeout(500)
            image = Image.open(io.BytesIO(page.screenshot(full_page=True, clip=clip)))
            image.convert("RGB").save(folder / f"{width}-{scheme}.webp", **WEBP)
        places[width] = {
            "size": list(image.size),
            "places": {name: [round(x - left), round(y - top), round(w), round(h)] for name, (x, y, w, h) in found.items()},
        }  # fmt: skip
    (folder / PLACES).write_text(json.dumps(places, indent=1) + "\n")


if __name__ == "__main__":
    main()
