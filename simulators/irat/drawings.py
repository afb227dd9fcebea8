"""Drawings of the museum's walls and the maze: textures as pictures whose sides are powers of two."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from robots.kit.drivers.irat.markers import BITS, CELL_M, CELLS, OUTER_IDS, OUTER_M, SMALL_ID, SMALL_M

Picture = NDArray[np.uint8]
Draw = ImageDraw.ImageDraw
Ink = tuple[int, int, int]
BOARD_M = 0.15  # side of the dock's board
INK: Ink = (38, 36, 44)
PAPERS: tuple[Ink, ...] = (
    (232, 88, 72), (250, 196, 70), (72, 160, 120), (64, 120, 190), (240, 236, 224), (148, 92, 168), (40, 172, 190),
    (238, 140, 58), (206, 92, 130), (120, 150, 60),
)  # fmt: skip


def _text(d: Draw, x: float, y: float, text: str, size: float, ink: Ink = INK) -> None:
    d.text((x, y), text, fill=ink, font=ImageFont.load_default(size), anchor="mm")


def _paw(d: Draw, n: int, ink: Ink) -> None:
    d.ellipse((n * 0.3, n * 0.48, n * 0.7, n * 0.86), fill=ink)
    for x, y in ((0.2, 0.36), (0.38, 0.18), (0.6, 0.18), (0.78, 0.36)):
        d.ellipse((n * (x - 0.09), n * (y - 0.1), n * (x + 0.09), n * (y + 0.12)), fill=ink)


def _star(d: Draw, n: int, ink: Ink) -> None:
    a = np.arange(10) * np.pi / 5 - np.pi / 2
    r = np.where(np.arange(10) % 2, 0.17, 0.42) * n
    d.polygon([(n / 2 + x, n / 2 + y) for x, y in zip(r * np.cos(a), r * np.sin(a), strict=True)], fill=ink)


def _cheese(d: Draw, n: int, ink: Ink) -> None:
    d.polygon((n * 0.08, n * 0.62, n * 0.92, n * 0.22, n * 0.92, n * 0.62), fill=(250, 206, 80))
    d.rectangle((n * 0.08, n * 0.62, n * 0.92, n * 0.82), fill=(232, 176, 50))
    for x, y, r in ((0.35, 0.72, 0.06), (0.7, 0.5, 0.09), (0.75, 0.74, 0.05)):
        d.ellipse((n * (x - r), n * (y - r), n * (x + r), n * (y + r)), fill=(190, 136, 30))


def _rings(d: Draw, n: int, ink: Ink) -> None:
    for r in (0.44, 0.28, 0.12):
        d.ellipse((n * (0.5 - r), n * (0.5 - r), n * (0.5 + r), n * (0.5 + r)), outline=ink, width=n // 11)


def _stripes(d: Draw, n: int, ink: Ink) -> None:
    for i in range(-4, 8, 2):
        d.polygon((n * i / 6, 0, n * (i + 1) / 6, 0, n * (i + 4) / 6, n, n * (i + 3) / 6, n), fill=ink)


def _arrow(d: Draw, n: int, ink: Ink) -> None:
    corners = (0.1, 0.4), (0.55, 0.4), (0.55, 0.2), (0.92, 0.5), (0.55, 0.8), (0.55, 0.6), (0.1, 0.6)
    d.polygon([(n * x, n * y) for x, y in corners], fill=ink)


def _chess(d: Draw, n: int, ink: Ink) -> None:
    for i in range(16):
        if (i // 4 + i) % 2:
            d.rectangle((i % 4 * n / 4, i // 4 * n / 4, (i % 4 + 1) * n / 4, (i // 4 + 1) * n / 4), fill=ink)


def _wave(d: Draw, n: int, ink: Ink) -> None:
    for row in (0.25, 0.5, 0.75):
        x = np.linspace(0, n, 40)
        d.line([(a, n * row + n * 0.08 * np.sin(a / n * 12)) for a in x], fill=ink, width=n // 12)


MOTIFS: tuple[Callable[[Draw, int, Ink], None], ...] = (_paw, _star, _cheese, _rings, _stripes, _arrow, _chess, _wave)


def sticker(number: int, side: int = 64) -> Picture:
    """Return one of many little posters: a motif, a letter or a number on coloured paper."""
    paper = PAPERS[(number * 7 + number // 10) % len(PAPERS)]
    ink = INK if sum(paper) > 330 else (246, 240, 226)
    image = Image.new("RGB", (side, side), (250, 248, 240))
    d = ImageDraw.Draw(image)
    inner = Image.new("RGB", (side - 6, side - 6), paper)
    if number % 3 == 2:
        text = "RATSLAMUQIBCDEFGHJKNOPVWXYZ0123456789"[number // 3 % 36]
        _text(ImageDraw.Draw(inner), side / 2 - 3, side / 2 - 4, text, side * 0.8, ink)
    else:
        MOTIFS[(number * 5 + number // 8) % len(MOTIFS)](ImageDraw.Draw(inner), side - 6, ink)
    image.paste(inner, (3, 3))
    d.rectangle((0, 0, side - 1, side - 1), outline=(205, 200, 190))
    return np.asarray(image)


def foam(side: int = 64) -> Picture:
    """Return the fine cells of cream foam."""
    grain = np.random.default_rng(3).normal(0, 5, (side, side, 1))
    return np.asarray(np.clip(np.array([233.0, 224.0, 203.0]) + grain, 0, 255), np.uint8)


def melamine(side: int = 256) -> Picture:
    """Return the black board: almost even, with the dust and scratches of use."""
    dice = np.random.default_rng(5)
    image = Image.new("RGB", (side, side), (23, 23, 26))
    d = ImageDraw.Draw(image)
    for _ in range(60):
        x, y = dice.uniform(0, side, 2)
        dx, dy = dice.normal(0, 12, 2)
        d.line((x, y, x + dx, y + dy), fill=tuple([int(dice.uniform(28, 38))] * 3))
    return np.asarray(np.clip(np.asarray(image) + dice.normal(0, 1.5, (side, side, 1)), 0, 255), np.uint8)


def parquet(side: int = 256) -> Picture:
    """Return the floor of the hall."""
    dice = np.random.default_rng(6)
    image = Image.new("RGB", (side, side))
    d = ImageDraw.Draw(image)
    for row in range(8):
        for column in range(-1, 4):
            x, y = column * 64 + row % 2 * 32, row * 32
            tone = dice.uniform(0.82, 1.05)
            d.rectangle((x, y, x + 63, y + 31), fill=tuple(int(v * tone) for v in (168, 124, 80)), outline=(96, 68, 44))
    return np.asarray(image)


def ceiling(side: int = 256) -> Picture:
    """Return the ceiling of the hall with its lamps."""
    image = Image.new("RGB", (side, side), (206, 206, 200))
    d = ImageDraw.Draw(image)
    for i in range(4):
        for j in range(2):
            d.rectangle(
                (20 + j * 128, 16 + i * 64, 108 + j * 128, 36 + i * 64), fill=(255, 255, 250), outline=(160, 160, 156)
            )
    return np.asarray(image)


def marker(number: int, cell: int) -> Image.Image:
    """Return a marker with `cell` pixels a cell, border included."""
    image = Image.new("L", (CELLS * cell, CELLS * cell), 0)
    d = ImageDraw.Draw(image)
    for row, bits in enumerate(BITS[number], 1):
        for column, bit in enumerate(bits, 1):
            if bit:
                d.rectangle((column * cell, row * cell, (column + 1) * cell - 1, (row + 1) * cell - 1), fill=255)
    return image


def dock_board(side: int = 512) -> Picture:
    """Return the dock's board: the outer marker, the small one in its centre, a mouse hole around both."""
    scale = side / BOARD_M
    image = Image.new("RGB", (side, side), (252, 252, 250))
    d = ImageDraw.Draw(image)
    d.arc((6, 4, side - 7, side * 1.6), 180, 360, fill=(150, 104, 62), width=14)
    outer = marker(OUTER_IDS[1], round(CELL_M * scale)).resize((round(OUTER_M * scale),) * 2)
    image.paste(outer, (round((BOARD_M - OUTER_M) / 2 * scale), round((BOARD_M - OUTER_M) / 2 * scale)))
    small = marker(SMALL_ID, 8).resize((round(SMALL_M * scale),) * 2, Image.Resampling.BOX)
    image.paste(small, (round((BOARD_M - SMALL_M) / 2 * scale), round((BOARD_M - SMALL_M) / 2 * scale)))
    return np.asarray(image)
