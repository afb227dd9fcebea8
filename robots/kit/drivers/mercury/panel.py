"""The composite picture of the classic console: camera, schematic, buttons, one grey GIF.

"This schematic is combined with the camera image, and the up, down, and air control
buttons to form a new composite image" (Goldberg et al. 1995, section 5); 64 greys save
bytes that nobody sees (section 6.6).
"""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from PIL import Image, ImageDraw, ImageFont

from robots.kit.drivers.mercury.scara import scara
from robots.kit.drivers.panels import Press

CAMERA = (0, 0, 192, 165)
SCHEMATIC = (192, 0, 336, 165)
BUTTONS_TOP, WIDTH, HEIGHT = 165, 336, 194
DISCRETE = ("up", "down", "air")
BUTTONS = (*DISCRETE, "stop")
DOWN_M = 0.001


def press(x: int, y: int, still: int, description: dict[str, Any], scale: int = 1) -> Press | None:
    """Return the command of a click at (x, y) in a panel shown `scale` times as large.

    None for a point outside the panel.
    """
    px, py = x / scale, y / scale
    if not (0 <= px < WIDTH and 0 <= py < HEIGHT):
        return None
    if py >= BUTTONS_TOP:
        return Press(BUTTONS[int(px * len(BUTTONS) // WIDTH)], {})
    if px < CAMERA[2]:
        return Press("click", {"still": still, "u": px, "v": py})
    u, v = (px - SCHEMATIC[0]) / (SCHEMATIC[2] - SCHEMATIC[0]), py / (SCHEMATIC[3] - 1)
    x0, y0, x1, y1 = description["classic"]["map"]
    return Press("move", {"x": x0 + u * (x1 - x0), "y": y1 - v * (y1 - y0)})


def form(fields: Mapping[str, str]) -> Press | None:
    """Return the command of the form below the picture; x and y of a move are in mm."""
    what = fields.get("do", "")
    if what in DISCRETE:
        return Press(what, {})
    if what == "move":
        return Press("move", {name: _metres(fields.get(f"{name}_mm", "")) for name in ("x", "y")})
    return None


def _metres(text: str) -> float | str:
    try:
        return float(text) / 1000
    except ValueError:
        return text  # the service names the error


def compose(picture: Path | None, description: dict[str, Any], joints: list[float], greys: int = 64) -> bytes:
    """Return the panel as GIF with `greys` shades of grey."""
    panel = Image.new("L", (WIDTH, HEIGHT), 215)
    if picture is not None:
        try:
            with Image.open(picture) as image:
                panel.paste(image.convert("L").resize((192, 165)), (0, 0))
        except OSError:
            pass  # the file is deleted: the screen stays empty
    draw = ImageDraw.Draw(panel)
    _schematic(draw, description, joints)
    down = len(joints) > 2 and joints[2] <= DOWN_M
    _buttons(draw, down)
    return _gif(panel, greys)


def at(x: float, y: float, description: dict[str, Any]) -> tuple[float, float]:
    """Return where in the panel the map shows the point (x, y) in m."""
    x0, y0, x1, y1 = description["classic"]["map"]
    return (
        SCHEMATIC[0] + (x - x0) / (x1 - x0) * (SCHEMATIC[2] - SCHEMATIC[0]),
        (y1 - y) / (y1 - y0) * (SCHEMATIC[3] - 1),
    )


def _schematic(draw: ImageDraw.ImageDraw, description: dict[str, Any], joints: list[float]) -> None:
    draw.rectangle((SCHEMATIC[0], 0, SCHEMATIC[2], SCHEMATIC[3]), fill=245)
    sand = description["sand"]
    low = at(sand["x"][0], sand["y"][1], description)
    high = at(sand["x"][1], sand["y"][0], description)
    draw.rectangle((*low, *high), fill=195, outline=110)
    if len(joints) < 4:
        return
    arm = scara(description)
    q = (joints[0], joints[1], joints[2], joints[3])
    elbow, tool = arm.elbow(q), arm.forward(q)
    points = [at(x, y, description) for x, y in ((0.0, 0.0), elbow[:2], tool[:2])]
    draw.line(points, fill=70, width=6, joint="curve")
    for (x, y), r in zip(points, (6, 4, 3), strict=True):
        draw.ellipse((x - r, y - r, x + r, y + r), fill=20)


def _buttons(draw: ImageDraw.ImageDraw, down: bool) -> None:
    font = ImageFont.load_default(14)
    width = WIDTH // len(BUTTONS)
    works = {"up": down, "down": not down, "air": down, "stop": True}
    for i, name in enumerate(BUTTONS):
        box = (i * width + 1, BUTTONS_TOP + 2, (i + 1) * width - 2, HEIGHT - 2)
        draw.rectangle(box, fill=250 if works[name] else 205, outline=60)
        draw.text(
            ((box[0] + box[2]) / 2, (box[1] + box[3]) / 2),
            name.upper(),
            fill=0 if works[name] else 130,
            font=font,
            anchor="mm",
        )


def _gif(panel: Image.Image, greys: int) -> bytes:
    step = 256 // greys
    reduced = panel.point([v // step for v in range(256)])
    paletted = Image.frombytes("P", panel.size, reduced.tobytes())
    shades = [round(i * 255 / (greys - 1)) for i in range(greys)]
    paletted.putpalette([c for s in shades for c in (s, s, s)])
    out = io.BytesIO()
    paletted.save(out, "GIF", optimize=True)
    return out.getvalue()
