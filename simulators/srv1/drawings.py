"""Drawings of the hall's surfaces and of things in its showcases: textures whose sides are powers of two."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

Picture = NDArray[np.uint8]
Draw = ImageDraw.ImageDraw
Ink = tuple[int, int, int]
FINER = 2  # drawn so many times as large, and averaged
BRASS: Ink = (206, 164, 84)


def drawing(width: int, height: int, paper: Ink, draw: Callable[[Draw, int, int], None]) -> Picture:
    """Return a drawing of that size; `draw` gets the size in which it draws."""
    image = Image.new("RGB", (width * FINER, height * FINER), paper)
    draw(ImageDraw.Draw(image), width * FINER, height * FINER)
    return np.asarray(image.resize((width, height), Image.Resampling.BOX))


def grained(picture: Picture, strength: float, seed: int) -> Picture:
    """Return the picture with a grain in its brightness."""
    grain = np.random.default_rng(seed).normal(0, strength, (*picture.shape[:2], 1))
    return np.asarray(np.clip(picture + grain, 0, 255), np.uint8)


def _tiles(d: Draw, w: int, h: int) -> None:
    dice = np.random.default_rng(2)
    for row in range(4):
        for column in range(4):
            x, y, n = column * w / 4, row * h / 4, w / 4
            pale = (row + column) % 2
            base = np.array((214, 203, 184) if pale else (134, 124, 116)) * dice.uniform(0.96, 1.04)
            d.rectangle((x, y, x + n, y + n), fill=tuple(base.astype(int)))
            for _ in range(5):  # veins of the stone
                a = dice.uniform(0, n, 2)
                points = [(x + a[0], y + a[1])]
                for _ in range(6):
                    a = np.clip(a + dice.normal(0, n / 7, 2), 2, n - 2)
                    points.append((x + a[0], y + a[1]))
                d.line(points, fill=tuple((base * dice.uniform(0.9, 1.07)).astype(int)), width=int(dice.integers(1, 4)))
            d.rectangle((x, y, x + n - 1, y + n - 1), outline=(98, 90, 82), width=3)


def floor() -> Picture:
    """Return 2 m x 2 m of the floor: four times four tiles of two kinds of stone."""
    return grained(drawing(512, 512, (170, 160, 150), _tiles), 3.0, 3)


def plaster() -> Picture:
    """Return the paint of the walls."""
    return grained(np.full((64, 64, 3), (104, 132, 134), np.uint8), 2.5, 4)


def _planks(d: Draw, w: int, h: int, tone: Ink) -> None:
    dice = np.random.default_rng(5)
    for row in range(4):
        y, n, base = row * h / 4, h / 4, np.array(tone) * dice.uniform(0.86, 1.06)
        d.rectangle((0, y, w, y + n), fill=tuple(base.astype(int)))
        for _ in range(16):
            at, x = y + dice.uniform(2, n - 2), dice.uniform(-w / 4, w)
            ink = tuple((base * dice.uniform(0.8, 1.1)).astype(int))
            d.line((x, at, x + dice.uniform(w / 6, w), at + dice.normal(0, 3)), fill=ink, width=2)
        d.line((0, y, w, y), fill=tuple((base * 0.55).astype(int)), width=2)


def wood(tone: Ink = (104, 66, 42)) -> Picture:
    """Return the wood of bases and doors."""
    return drawing(128, 128, tone, partial(_planks, tone=tone))


def black_glass() -> Picture:
    """Return black glass with reflections of the hall's lamps."""

    def draw(d: Draw, w: int, h: int) -> None:
        for y in range(h):
            grey = int(16 + 26 * (1 - y / h) ** 2)
            d.line((0, y, w, y), fill=(grey, grey, grey + 5))
        for x, wide in ((0.16, 0.05), (0.24, 0.015), (0.7, 0.07)):
            d.polygon(((x + 0.2) * w, 0, (x + wide + 0.2) * w, 0, (x + wide - 0.1) * w, h, (x - 0.1) * w, h),
                      fill=(52, 54, 62))  # fmt: skip

    return drawing(128, 128, (16, 16, 20), draw)


def ceiling() -> Picture:
    """Return 4 m x 4 m of the ceiling: beams, and lamps between them."""

    def draw(d: Draw, w: int, h: int) -> None:
        for i in range(2):
            d.rectangle((0, i * h / 2, w, i * h / 2 + h / 14), fill=(84, 66, 52))
            for j in range(2):
                x, y = (j + 0.5) * w / 2, (i + 0.55) * h / 2
                d.ellipse(
                    (x - w / 22, y - h / 22, x + w / 22, y + h / 22), fill=(255, 250, 226), outline=(170, 160, 140)
                )

    return drawing(256, 256, (188, 184, 174), draw)


def plate(text: str) -> Picture:
    """Return a plate of brass with a name on it."""

    def draw(d: Draw, w: int, h: int) -> None:
        d.rectangle((0, 0, w - 1, h - 1), outline=(120, 90, 40), width=6)
        font = ImageFont.load_default(min(h * 0.56, 1.55 * w / max(4, len(text))))
        d.text((w / 2, h / 2), text.upper(), fill=(52, 36, 18), font=font, anchor="mm")

    return drawing(256, 64, BRASS, draw)


def spiral() -> Picture:
    """Return an ammonite from its side, on a square whose inner circle it fills."""

    def draw(d: Draw, w: int, h: int) -> None:
        for turn in np.linspace(0, 6 * np.pi, 150)[::-1]:
            r = 0.46 * w * np.exp((turn - 6 * np.pi) * 0.115)
            x, y, thick = w / 2 + 0.72 * r * np.cos(turn), h / 2 + 0.72 * r * np.sin(turn), 0.30 * r
            tone = 0.72 + 0.28 * np.cos(turn * 7)
            ink = tuple(int(v * tone) for v in (196, 158, 108))
            d.ellipse((x - thick, y - thick, x + thick, y + thick), fill=ink)
            d.ellipse(
                (x - thick / 3, y - thick / 2, x + thick / 4, y), fill=tuple(min(255, int(v * 1.12)) for v in ink)
            )

    return drawing(128, 128, (112, 88, 62), draw)


def beetle(d: Draw, x: float, y: float, n: float, ink: Ink) -> None:
    """Draw a beetle of length `n` (pixels), its head upwards."""
    for side in (-1, 1):
        for leg, bend in ((-0.18, -0.22), (0.02, 0.02), (0.2, 0.3)):
            d.line((x, y + leg * n, x + side * 0.34 * n, y + bend * n, x + side * 0.42 * n, y + (bend + 0.12) * n),
                   fill=(30, 24, 20), width=max(2, int(n / 26)))  # fmt: skip
        d.line((x, y - 0.4 * n, x + side * 0.2 * n, y - 0.6 * n), fill=(30, 24, 20), width=max(2, int(n / 30)))
    d.ellipse((x - 0.12 * n, y - 0.5 * n, x + 0.12 * n, y - 0.3 * n), fill=(34, 28, 26))
    d.ellipse((x - 0.2 * n, y - 0.4 * n, x + 0.2 * n, y - 0.12 * n), fill=tuple(v * 2 // 3 for v in ink))
    d.ellipse((x - 0.26 * n, y - 0.24 * n, x + 0.26 * n, y + 0.5 * n), fill=ink)
    d.ellipse((x - 0.18 * n, y - 0.14 * n, x - 0.06 * n, y + 0.2 * n), fill=tuple(min(255, v + 70) for v in ink))
    d.line((x, y - 0.2 * n, x, y + 0.5 * n), fill=(24, 20, 18), width=max(2, int(n / 40)))


BEETLES: tuple[Ink, ...] = (
    (28, 110, 70), (150, 40, 34), (40, 60, 140), (190, 140, 30), (66, 46, 34), (20, 130, 130), (110, 40, 120),
    (200, 90, 30),
)  # fmt: skip


def collection() -> Picture:
    """Return a drawer of beetles in rows, each with its label."""

    def draw(d: Draw, w: int, h: int) -> None:
        for row in range(2):
            for column in range(5):
                x, y, n = (column + 0.5) * w / 5, (row + 0.44) * h / 2, h / 3.4
                beetle(d, x, y, n * (0.8 + 0.2 * ((row + column) % 2)), BEETLES[(row * 5 + column * 3) % len(BEETLES)])
                d.rectangle(
                    (x - n / 3, y + 0.72 * n, x + n / 3, y + 0.86 * n), fill=(252, 250, 240), outline=(150, 140, 120)
                )

    return drawing(512, 256, (240, 232, 212), draw)


def coins() -> Picture:
    """Return a board of gold, silver and copper coins."""

    def draw(d: Draw, w: int, h: int) -> None:
        for row in range(4):
            for column in range(8):
                x, y, r = (column + 0.5) * w / 8, (row + 0.5) * h / 4, h / 10.5
                ink = ((222, 178, 70), (196, 196, 200), (184, 112, 68))[(row * 3 + column * 5) % 3]
                dark = tuple(v * 2 // 3 for v in ink)
                d.ellipse((x - r, y - r, x + r, y + r), fill=dark)
                d.ellipse((x - 0.88 * r, y - 0.88 * r, x + 0.88 * r, y + 0.88 * r), fill=ink)
                d.ellipse((x - 0.3 * r, y - 0.55 * r, x + 0.35 * r, y + 0.15 * r), fill=dark)
                d.pieslice((x - 0.6 * r, y, x + 0.6 * r, y + 1.2 * r), 190, 350, fill=dark)

    return drawing(512, 256, (92, 28, 40), draw)


def exit_sign() -> Picture:
    """Return the green sign over the door."""

    def draw(d: Draw, w: int, h: int) -> None:
        d.text((w * 0.38, h / 2), "EXIT", fill=(250, 255, 250), font=ImageFont.load_default(h * 0.62), anchor="mm")
        d.polygon((w * 0.66, h * 0.4, w * 0.8, h * 0.4, w * 0.8, h * 0.2, w * 0.94, h * 0.5, w * 0.8, h * 0.8, w * 0.8,
                   h * 0.6, w * 0.66, h * 0.6), fill=(250, 255, 250))  # fmt: skip

    return drawing(128, 32, (20, 130, 70), draw)
