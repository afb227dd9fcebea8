"""The objects in the sand: drawn shapes with a height, all from one story.

The public has to find out which story. Sizes in mm, one pixel is half a millimetre. Where each lies in a bed is in
`robots.kit.drivers.mercury.beds`.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

PIXEL_MM = 0.5
Draw = ImageDraw.ImageDraw
DARK, MID, LIGHT = 40, 120, 235


@dataclass(frozen=True)
class Artifact:
    """An object: its name (never shown), its size in mm, depth of its top, its drawing."""

    name: str
    width_mm: float
    height_mm: float
    depth_mm: float
    thick_mm: float
    turn_deg: float
    draw: Callable[[Draw, int, int], None]
    gloss: float = 0.0  # share of a lamp's light that it reflects like a mirror
    dome_mm: float = 0.0  # height of its middle above its rim

    def sprite(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return (albedo 0..1, mask 0..1), each of shape (rows, columns), y up."""
        size = (int(self.width_mm / PIXEL_MM), int(self.height_mm / PIXEL_MM))
        image = Image.new("LA", size, (0, 0))
        self.draw(ImageDraw.Draw(image), *size)
        image = image.rotate(self.turn_deg, Image.Resampling.BICUBIC, expand=True)
        grey, mask = image.split()
        return _floats(grey), _floats(mask)


def _floats(image: Image.Image) -> NDArray[np.float32]:
    return np.asarray(image, np.float32)[::-1] / 255.0


def _text(d: Draw, xy: tuple[float, float], text: str, size: float, grey: int = DARK) -> None:
    d.text(xy, text, fill=(grey, 255), font=ImageFont.load_default(size), anchor="mm")


def _watch(d: Draw, w: int, h: int) -> None:
    r = w // 2 - 2
    cx, cy = w // 2, h - r - 3
    d.rectangle((cx - 7, 0, cx + 7, h - 2 * r), fill=(150, 255))
    d.ellipse((cx - r, cy - r, cx + r, cy + r), fill=(150, 255))
    d.ellipse((cx - r + 5, cy - r + 5, cx + r - 5, cy + r - 5), fill=(LIGHT, 255))
    for hour in range(12):
        a = hour * np.pi / 6
        x, y = cx + (r - 11) * np.sin(a), cy - (r - 11) * np.cos(a)
        d.ellipse((x - 2, y - 2, x + 2, y + 2), fill=(DARK, 255))
    d.line((cx, cy, cx - r * 0.25, cy - r * 0.45), fill=(DARK, 255), width=5)
    d.line((cx, cy, cx - r * 0.55, cy + r * 0.25), fill=(DARK, 255), width=3)


def _card(d: Draw, w: int, h: int) -> None:
    d.rounded_rectangle((1, 1, w - 2, h - 2), 7, fill=(LIGHT, 255), outline=(90, 255), width=2)
    _text(d, (12, 13), "A", 20)
    _text(d, (w - 12, h - 13), "A", 20)
    cx, cy, s = w / 2, h / 2, w * 0.26
    d.ellipse((cx - s, cy - s * 0.4, cx, cy + s * 0.6), fill=(DARK, 255))
    d.ellipse((cx, cy - s * 0.4, cx + s, cy + s * 0.6), fill=(DARK, 255))
    d.polygon((cx - s, cy, cx + s, cy, cx, cy - s * 1.4), fill=(DARK, 255))
    d.polygon((cx, cy, cx - s * 0.4, cy + s * 1.2, cx + s * 0.4, cy + s * 1.2), fill=(DARK, 255))


def _elephant(d: Draw, w: int, h: int) -> None:
    g = (95, 255)
    d.ellipse((w * 0.22, h * 0.15, w * 0.95, h * 0.72), fill=g)
    d.ellipse((w * 0.02, h * 0.10, w * 0.42, h * 0.58), fill=g)
    for x in (0.30, 0.46, 0.68, 0.82):
        d.rectangle((w * x, h * 0.5, w * (x + 0.10), h * 0.98), fill=g)
    d.line((w * 0.08, h * 0.4, w * 0.06, h * 0.7, w * 0.14, h * 0.9), fill=g, width=9, joint="curve")
    d.ellipse((w * 0.2, h * 0.14, w * 0.44, h * 0.52), fill=(60, 255))
    d.ellipse((w * 0.11, h * 0.24, w * 0.15, h * 0.30), fill=(LIGHT, 255))
    d.line((w * 0.12, h * 0.56, w * 0.24, h * 0.72), fill=(LIGHT, 255), width=4)


def _engine(d: Draw, w: int, h: int) -> None:
    g = (70, 255)
    d.rectangle((w * 0.25, h * 0.38, w * 0.95, h * 0.68), fill=g)
    d.rectangle((w * 0.03, h * 0.12, w * 0.32, h * 0.70), fill=g)
    d.rectangle((w * 0.09, h * 0.2, w * 0.25, h * 0.4), fill=(LIGHT, 255))
    d.polygon((w * 0.76, h * 0.38, w * 0.72, h * 0.05, w * 0.92, h * 0.05, w * 0.88, h * 0.38), fill=g)
    d.ellipse((w * 0.5, h * 0.26, w * 0.62, h * 0.46), fill=g)
    for x in (0.06, 0.36, 0.66):
        d.ellipse((w * x, h * 0.6, w * (x + 0.26), h * 0.99), fill=(MID, 255), outline=(30, 255), width=4)


def _banknote(d: Draw, w: int, h: int) -> None:
    d.rectangle((1, 1, w - 2, h - 2), fill=(200, 255), outline=(80, 255), width=3)
    d.rectangle((8, 8, w - 9, h - 9), outline=(120, 255), width=1)
    _text(d, (w / 2, h * 0.42), "20000", h * 0.40)
    _text(d, (w / 2, h * 0.78), "POUNDS STERLING", h * 0.14)


def _ticket(d: Draw, w: int, h: int) -> None:
    d.rounded_rectangle((1, 1, w - 2, h - 2), 4, fill=(225, 255), outline=(80, 255), width=2)
    _text(d, (w / 2, h * 0.30), "LONDON", h * 0.26)
    _text(d, (w / 2, h * 0.56), "SUEZ BOMBAY", h * 0.18)
    _text(d, (w / 2, h * 0.80), "OCT 2 1872", h * 0.19)


def _leaf(d: Draw, w: int, h: int) -> None:
    d.rectangle((1, 1, w - 2, h - 2), fill=(230, 255), outline=(80, 255), width=2)
    d.rectangle((1, 1, w - 2, h * 0.26), fill=(90, 255))
    _text(d, (w / 2, h * 0.14), "DECEMBER", h * 0.15, LIGHT)
    _text(d, (w / 2, h * 0.62), "21", h * 0.55)


def _bag(d: Draw, w: int, h: int) -> None:
    d.arc((w * 0.3, 2, w * 0.7, h * 0.6), 180, 360, fill=(50, 255), width=7)
    d.rounded_rectangle((2, h * 0.3, w - 3, h - 3), 12, fill=(110, 255), outline=(50, 255), width=4)
    for row in range(3):
        for column in range(5):
            x, y = w * (0.14 + 0.18 * column), h * (0.44 + 0.2 * row)
            d.regular_polygon((x, y, 6), 4, fill=(170, 255))
    d.rectangle((w * 0.44, h * 0.26, w * 0.56, h * 0.42), fill=(LIGHT, 255))


def _gasburner(d: Draw, w: int, h: int) -> None:
    d.rectangle((w * 0.42, h * 0.4, w * 0.58, h * 0.95), fill=(90, 255))
    d.rectangle((w * 0.15, h * 0.86, w * 0.85, h * 0.98), fill=(60, 255))
    d.polygon((w * 0.5, 2, w * 0.78, h * 0.3, w * 0.5, h * 0.46, w * 0.22, h * 0.3), fill=(LIGHT, 255))


ARTIFACTS = (
    Artifact("watch", 34, 44, 9, 6, 14, _watch, gloss=0.8, dome_mm=5),
    Artifact("whist card", 30, 42, 7, 1.5, -22, _card),
    Artifact("elephant", 46, 36, 12, 8, 6, _elephant),
    Artifact("engine", 50, 32, 10, 8, -8, _engine, gloss=0.25, dome_mm=6),
    Artifact("banknote", 56, 30, 8, 1.5, 31, _banknote),
    Artifact("ticket", 44, 28, 8, 1.5, -14, _ticket),
    Artifact("calendar leaf", 32, 36, 11, 1.5, 9, _leaf),
    Artifact("bag", 42, 34, 13, 9, -5, _bag),
    Artifact("gas burner", 22, 40, 10, 6, 40, _gasburner, gloss=0.5, dome_mm=5),
)
