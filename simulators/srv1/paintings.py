"""Paintings on the walls of the hall, and the map on its globe."""

from collections.abc import Callable
from math import cos, pi, sin

import numpy as np

from simulators.srv1.drawings import BEETLES, Draw, Ink, Picture, beetle, drawing

SEA: Ink = (52, 104, 150)
LANDS: tuple[tuple[tuple[float, float], ...], ...] = (  # longitude and latitude, in degrees, coarse
    ((-168, 66), (-140, 70), (-95, 72), (-62, 58), (-54, 48), (-68, 44), (-80, 27), (-97, 26), (-95, 17), (-83, 9),
     (-90, 15), (-106, 22), (-117, 33), (-124, 44), (-134, 58), (-152, 59)),
    ((-80, 8), (-62, 10), (-50, 0), (-35, -7), (-40, -22), (-54, -34), (-66, -45), (-69, -54), (-74, -50), (-71, -18),
     (-81, -5)),
    ((-10, 36), (-9, 43), (0, 49), (8, 54), (6, 60), (14, 67), (28, 71), (60, 69), (90, 75), (130, 72), (178, 68),
     (160, 60), (140, 52), (128, 38), (121, 30), (108, 20), (104, 2), (98, 16), (90, 22), (80, 8), (72, 20), (60, 25),
     (56, 18), (45, 13), (36, 30), (27, 37), (16, 40), (6, 43)),
    ((-17, 15), (-6, 35), (10, 37), (32, 31), (43, 11), (51, 11), (40, -4), (40, -16), (32, -28), (20, -35), (14, -22),
     (9, 3), (-8, 5)),
    ((114, -22), (130, -12), (142, -11), (153, -27), (146, -39), (132, -32), (116, -35)),
    ((-52, 60), (-25, 70), (-20, 80), (-60, 82), (-70, 76)),
    ((-180, -70), (-60, -66), (60, -66), (180, -70), (180, -90), (-180, -90)),
)  # fmt: skip


def _world(d: Draw, w: int, h: int) -> None:
    for number, land in enumerate(LANDS):
        ink = ((150, 160, 92), (110, 150, 84), (176, 160, 100), (202, 170, 104), (206, 150, 90), (236, 240, 240),
               (240, 242, 244))[number]  # fmt: skip
        d.polygon([((x / 360 + 0.5) * w, (0.5 - y / 180) * h) for x, y in land], fill=ink, outline=(84, 92, 60))
    for i in range(12):
        d.line((i * w / 12, 0, i * w / 12, h), fill=(84, 130, 168))
    for i in range(1, 6):
        d.line((0, i * h / 6, w, i * h / 6), fill=(84, 130, 168), width=4 if i == 3 else 1)


def _mammoth(d: Draw, w: int, h: int) -> None:
    for y in range(int(h * 0.62)):
        d.line((0, y, w, y), fill=(int(150 + 90 * y / h), int(176 + 70 * y / h), 222))
    hills = ((0.0, 0.5), (0.2, 0.3), (0.4, 0.52), (0.65, 0.26), (1.0, 0.55), (1.0, 0.7), (0.0, 0.7))
    d.polygon([(w * x, h * y) for x, y in hills], fill=(150, 168, 190))
    d.rectangle((0, h * 0.62, w, h), fill=(236, 240, 246))
    fur: Ink = (98, 62, 38)
    for x in (0.34, 0.42, 0.6, 0.67):
        d.rectangle((w * x, h * 0.6, w * (x + 0.055), h * 0.86), fill=(78, 48, 30))
    d.ellipse((w * 0.3, h * 0.32, w * 0.76, h * 0.76), fill=fur)
    d.ellipse((w * 0.6, h * 0.22, w * 0.82, h * 0.6), fill=fur)
    d.arc((w * 0.7, h * 0.3, w * 0.9, h * 0.84), 20, 190, fill=fur, width=int(w * 0.035))
    for grow in (0.0, 0.03):
        d.arc(
            (w * (0.66 + grow), h * 0.36, w * (0.92 + grow), h * 0.74), 20, 150, fill=(250, 244, 224), width=int(w / 60)
        )
    d.ellipse((w * 0.73, h * 0.34, w * 0.745, h * 0.36), fill=(12, 10, 8))


def _reef(d: Draw, w: int, h: int) -> None:
    for row in range(h):
        d.line((0, row, w, row), fill=(20, int(120 - 70 * row / h), int(170 - 70 * row / h)))
    for x, y, r in ((0.3, 0.4, 0.2), (0.7, 0.3, 0.13), (0.66, 0.72, 0.16)):
        for bend in (-0.3, -0.15, 0.0, 0.15):  # its arms
            end = w * (x + r * 1.7), h * (y + r * 0.7 + bend)
            d.line((w * (x + r * 0.9), h * (y + r * 0.6), *end), fill=(230, 170, 140), width=4)
        for i in range(5):
            s = r * (1 - i * 0.2)
            tone = 1 - 0.12 * i
            box = (w * (x - s), h * (y - s * 1.3), w * (x + s), h * (y + s * 1.3))
            d.ellipse(box, fill=tuple(int(v * tone) for v in (236, 190, 120)), outline=(120, 80, 50), width=4)
    for x in np.linspace(0.04, 0.96, 9):
        d.arc((w * (x - 0.05), h * 0.8, w * (x + 0.05), h * 1.2), 180, 300, fill=(200, 80, 110), width=10)


def _dinosaur(d: Draw, w: int, h: int) -> None:
    for y in range(h):
        d.line((0, y, w, y), fill=(240, int(190 - 120 * y / h), int(90 + 40 * y / h)))
    d.ellipse((w * 0.58, h * 0.2, w * 0.82, h * 0.54), fill=(255, 236, 170))
    d.polygon((0, h * 0.74, w * 0.3, h * 0.66, w * 0.7, h * 0.76, w, h * 0.68, w, h, 0, h), fill=(60, 40, 44))
    dark: Ink = (36, 26, 36)
    d.ellipse((w * 0.28, h * 0.46, w * 0.64, h * 0.74), fill=dark)
    for x in (0.32, 0.4, 0.53, 0.58):
        d.rectangle((w * x, h * 0.62, w * (x + 0.04), h * 0.86), fill=dark)
    neck = [(w * (0.6 + 0.16 * t), h * (0.56 - 0.4 * sin(t * pi / 2))) for t in np.linspace(0, 1, 12)]
    tail = [(w * (0.32 - 0.3 * t), h * (0.58 + 0.16 * t * t)) for t in np.linspace(0, 1, 12)]
    for row, thick in ((neck, 0.05), (tail, 0.07)):
        for i, (x, y) in enumerate(row):
            r = w * thick * (1 - 0.07 * i)
            d.ellipse((x - r / 2, y - r / 2, x + r / 2, y + r / 2), fill=dark)
        d.line(row, fill=dark, width=int(w * thick * 0.5))
    d.ellipse((w * 0.73, h * 0.11, w * 0.85, h * 0.2), fill=dark)


def _planet(d: Draw, w: int, h: int) -> None:
    dice = np.random.default_rng(8)
    for x, y, r in zip(dice.uniform(0, w, 160), dice.uniform(0, h, 160), dice.uniform(1, 4, 160), strict=True):
        d.ellipse((x - r, y - r, x + r, y + r), fill=(250, 246, 220))
    d.ellipse((w * 0.14, h * 0.36, w * 0.86, h * 0.66), outline=(206, 178, 140), width=int(w / 30))
    d.ellipse((w * 0.32, h * 0.22, w * 0.68, h * 0.8), fill=(226, 186, 120))
    for i, tone in enumerate((0.9, 1.04, 0.84, 0.96)):
        y = h * (0.36 + 0.09 * i)
        half = w * 0.18 * cos((i - 1.4) * 0.55)
        d.rectangle(
            (w / 2 - half, y, w / 2 + half, y + h * 0.045), fill=tuple(min(255, int(v * tone)) for v in (226, 186, 120))
        )
    d.arc((w * 0.14, h * 0.36, w * 0.86, h * 0.66), 10, 170, fill=(206, 178, 140), width=int(w / 30))


def _butterflies(d: Draw, w: int, h: int) -> None:
    inks: tuple[Ink, ...] = (
        (214, 110, 40),
        (52, 110, 190),
        (240, 200, 60),
        (160, 60, 110),
        (60, 150, 120),
        (200, 60, 50),
    )
    for i, ink in enumerate(inks):
        x, y, n = (i % 3 + 0.5) * w / 3, (i // 3 + 0.5) * h / 2, w / 8
        for side in (-1, 1):
            a, b = sorted((x, x + side * n))
            d.ellipse((a, y - 0.9 * n, b, y + 0.15 * n), fill=ink, outline=(30, 24, 24), width=5)
            a, b = sorted((x, x + side * 0.75 * n))
            d.ellipse((a, y, b, y + 0.85 * n), fill=tuple(v * 3 // 4 for v in ink), outline=(30, 24, 24), width=5)
            spot = x + side * 0.6 * n
            d.ellipse((spot - n / 9, y - 0.5 * n, spot + n / 9, y - 0.28 * n), fill=(252, 248, 230))
            d.line((x, y - 0.5 * n, x + side * 0.25 * n, y - 1.05 * n), fill=(30, 24, 24), width=4)
        d.ellipse((x - n / 12, y - 0.6 * n, x + n / 12, y + 0.6 * n), fill=(40, 30, 28))


def _volcano(d: Draw, w: int, h: int) -> None:
    for row in range(h):
        d.line((0, row, w, row), fill=(int(40 + 60 * row / h), int(44 + 40 * row / h), int(84 + 10 * row / h)))
    for x, y, r in ((0.5, 0.16, 0.2), (0.62, 0.1, 0.16), (0.4, 0.08, 0.16)):
        d.ellipse((w * (x - r), h * (y - r * 0.7), w * (x + r), h * (y + r * 0.7)), fill=(110, 92, 96))
    d.polygon((w * 0.42, h * 0.3, w * 0.58, h * 0.3, w * 0.98, h, w * 0.02, h), fill=(64, 50, 52))
    for x, bend in ((0.46, -0.2), (0.5, 0.04), (0.54, 0.26)):
        d.line(
            (w * x, h * 0.3, w * (x + bend * 0.4), h * 0.6, w * (x + bend), h), fill=(250, 120, 40), width=int(w / 34)
        )
        d.line((w * x, h * 0.3, w * (x + bend * 0.4), h * 0.6), fill=(255, 214, 110), width=int(w / 70))


def _strata(d: Draw, w: int, h: int) -> None:
    inks: tuple[Ink, ...] = (
        (120, 150, 84), (176, 140, 92), (206, 180, 130), (150, 104, 78), (190, 150, 110), (116, 84, 72), (84, 74, 76),
    )  # fmt: skip
    x = np.linspace(0, w, 40)
    for i, ink in enumerate(inks):
        y = h * (0.12 + 0.125 * i) + h * 0.03 * np.sin(x / w * 7 + i)
        d.polygon([*zip(x, y, strict=True), (w, h), (0, h)], fill=ink)
    for a, b in ((0.25, 0.4), (0.7, 0.66), (0.42, 0.86)):
        for r in (0.06, 0.042, 0.024):
            d.ellipse(
                (w * (a - r), h * (b - r * 1.3), w * (a + r), h * (b + r * 1.3)), outline=(250, 240, 214), width=6
            )


def _whale(d: Draw, w: int, h: int) -> None:
    for y in range(h):
        d.line((0, y, w, y), fill=(int(120 - 90 * y / h), int(190 - 110 * y / h), int(214 - 90 * y / h)))
    d.pieslice((w * 0.1, h * 0.2, w * 0.8, h * 0.84), 0, 360, fill=(56, 76, 100))
    d.chord((w * 0.12, h * 0.34, w * 0.7, h * 0.86), 20, 170, fill=(206, 214, 220))
    d.polygon((w * 0.74, h * 0.5, w * 0.98, h * 0.26, w * 0.9, h * 0.52, w * 0.98, h * 0.72), fill=(56, 76, 100))
    d.polygon((w * 0.36, h * 0.62, w * 0.5, h * 0.66, w * 0.34, h * 0.92), fill=(44, 60, 82))
    d.ellipse((w * 0.2, h * 0.48, w * 0.225, h * 0.51), fill=(10, 12, 16))


def _plate(d: Draw, w: int, h: int) -> None:
    for i in range(3):
        beetle(d, (i + 0.5) * w / 3, h * 0.5, h * (0.52, 0.7, 0.52)[i], BEETLES[i])


PAINTINGS: tuple[tuple[Ink, Callable[[Draw, int, int], None]], ...] = (
    ((236, 240, 246), _mammoth), ((20, 90, 140), _reef), ((240, 160, 90), _dinosaur), ((14, 18, 46), _planet),
    ((244, 236, 216), _butterflies), ((40, 44, 84), _volcano), ((176, 206, 226), _strata), ((60, 120, 150), _whale),
    ((240, 230, 206), _plate), (SEA, _world),
)  # fmt: skip


def painting(number: int) -> Picture:
    """Return a painting of 256 x 256, to be hung 4 : 3."""
    paper, draw = PAINTINGS[number % len(PAINTINGS)]
    return drawing(256, 256, paper, draw)


def globe() -> Picture:
    """Return the map of the world by longitude and latitude."""
    return drawing(512, 256, SEA, _world)
