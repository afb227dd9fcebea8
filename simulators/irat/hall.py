"""The hall around the maze: four walls as pictures of 1024 x 512, each unlike the others."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

Picture = NDArray[np.uint8]
Draw = ImageDraw.ImageDraw
Ink = tuple[int, int, int]
W, H = 1024, 512
FLOOR_Y = 470  # where the skirting board begins


def _wall(paper: Ink) -> tuple[Image.Image, Draw]:
    image = Image.new("RGB", (W, H), paper)
    d = ImageDraw.Draw(image)
    d.rectangle((0, 0, W, 26), fill=(236, 232, 222))
    d.rectangle((0, FLOOR_Y, W, H), fill=(84, 66, 52))
    return image, d


def _visitor(d: Draw, x: float, tall: float, coat: Ink, hair: Ink, trousers: Ink = (46, 50, 66)) -> None:
    """Draw somebody who stands and looks."""
    top, wide = H - 12 - tall, tall * 0.13
    d.rectangle((x - wide * 0.75, top + tall * 0.52, x + wide * 0.75, H - 8), fill=trousers)
    d.rounded_rectangle((x - wide, top + tall * 0.17, x + wide, top + tall * 0.6), wide * 0.6, fill=coat)
    d.ellipse((x - wide * 0.55, top, x + wide * 0.55, top + tall * 0.17), fill=(224, 178, 146))
    d.pieslice((x - wide * 0.62, top - 4, x + wide * 0.62, top + tall * 0.15), 180, 360, fill=hair)


def _framed(d: Draw, box: tuple[int, int, int, int], frame: Ink = (150, 112, 48)) -> tuple[int, int, int, int]:
    x, y, a, b = box
    d.rectangle((x - 10, y - 10, a + 10, b + 10), fill=frame, outline=(90, 64, 26), width=3)
    return box


def windows() -> Picture:
    """Return the wall with three high windows over a town."""
    image, d = _wall((196, 204, 206))
    for i, x in enumerate((70, 390, 710)):
        d.rectangle((x, 60, x + 240, 400), fill=(250, 250, 246))
        d.rectangle((x + 12, 72, x + 228, 388), fill=(150, 200, 236))
        d.ellipse((x + 20 + 50 * i, 96, x + 100 + 50 * i, 126), fill=(240, 246, 250))
        for j, tall in enumerate(((90, 150, 60, 190, 110), (130, 70, 200, 90, 150), (60, 170, 120, 80, 210))[i]):
            left = x + 14 + j * 43
            tone = (126 + 14 * j, 96 + 20 * ((i + j) % 3), 92)
            d.rectangle((left, 388 - tall, left + 40, 388), fill=tone)
            for k in range(8, tall - 8, 18):
                d.rectangle((left + 8, 388 - k - 8, left + 15, 388 - k), fill=(250, 224, 140))
                d.rectangle((left + 24, 388 - k - 8, left + 31, 388 - k), fill=(70, 70, 90))
        d.line((x + 120, 72, x + 120, 388), fill=(250, 250, 246), width=8)
        d.line((x + 12, 190, x + 228, 190), fill=(250, 250, 246), width=8)
    for x, tall, coat, hair in ((346, 250, (190, 62, 58), (60, 40, 30)), (674, 180, (64, 130, 190), (200, 160, 80))):
        _visitor(d, x, tall, coat, hair)
    return np.asarray(image)


def gallery() -> Picture:
    """Return the wall with paintings."""
    image, d = _wall((122, 34, 44))
    x, y, a, b = _framed(d, (60, 90, 300, 280))
    d.rectangle((x, y, a, b), fill=(240, 170, 90))
    d.ellipse((x + 90, y + 40, x + 160, y + 110), fill=(252, 240, 190))
    d.polygon((x, b, x, y + 130, x + 80, y + 90, x + 160, y + 150, a, y + 110, a, b), fill=(60, 70, 110))
    x, y, a, b = _framed(d, (380, 70, 560, 330), (60, 60, 60))
    d.rectangle((x, y, a, b), fill=(236, 230, 214))
    for i, ink in enumerate(((214, 48, 40), (36, 84, 168), (246, 200, 40), (20, 20, 20))):
        d.rectangle((x + 20 + (i % 2) * 80, y + 24 + i * 54, x + 70 + (i % 2) * 90, y + 66 + i * 54), fill=ink)
    x, y, a, b = _framed(d, (640, 110, 820, 260))
    d.rectangle((x, y, a, b), fill=(70, 110, 80))
    d.ellipse((x + 40, y + 30, x + 140, y + 140), fill=(196, 190, 184))
    d.ellipse((x + 22, y + 14, x + 66, y + 58), fill=(214, 160, 160))
    d.ellipse((x + 112, y + 14, x + 156, y + 58), fill=(214, 160, 160))
    for eye in (66, 102):
        d.ellipse((x + eye, y + 66, x + eye + 12, y + 78), fill=(20, 20, 20))
    x, y, a, b = _framed(d, (880, 80, 980, 300), (200, 200, 196))
    d.rectangle((x, y, a, b), fill=(30, 40, 80))
    for i in range(26):
        d.point((x + (i * 37) % 98, y + (i * 61) % 210), fill=(255, 255, 230))
        d.ellipse(
            (x + (i * 37) % 94, y + (i * 61) % 206, x + (i * 37) % 94 + 4, y + (i * 61) % 206 + 4), fill=(250, 240, 200)
        )
    for x, tall, coat in ((340, 240, (230, 190, 60)), (604, 255, (40, 60, 70)), (850, 165, (110, 180, 120))):
        _visitor(d, x, tall, coat, (30, 26, 24))
    return np.asarray(image)


def library() -> Picture:
    """Return the wall with shelves of books and a door."""
    image, d = _wall((60, 84, 74))
    dice = np.random.default_rng(11)
    for left, right in ((30, 420), (640, 1000)):
        d.rectangle((left, 60, right, FLOOR_Y), fill=(92, 62, 38))
        for shelf in range(5):
            y, x = 76 + shelf * 80, left + 10.0
            d.rectangle((left + 6, y, right - 6, y + 66), fill=(46, 32, 22))
            while x < right - 24:
                wide, tall = dice.uniform(8, 22), dice.uniform(34, 64)
                ink = tuple(int(v) for v in dice.uniform(40, 235, 3))
                if dice.random() > 0.08:
                    d.rectangle((x, y + 66 - tall, x + wide - 1, y + 66), fill=ink)
                x += wide
    d.rectangle((460, 120, 600, FLOOR_Y), fill=(226, 214, 190))
    d.rectangle((474, 134, 586, FLOOR_Y), fill=(248, 236, 200))
    _visitor(d, 530, 260, (90, 60, 120), (120, 70, 40))
    return np.asarray(image)


def banners() -> Picture:
    """Return the wall with banners and plants."""
    image, d = _wall((224, 206, 168))
    for x, ink, text in ((80, (34, 110, 140), "RATS"), (330, (210, 80, 50), "MAPS"), (760, (90, 130, 60), "MINDS")):
        d.rectangle((x, 40, x + 150, 380), fill=ink)
        d.polygon((x, 380, x + 75, 340, x + 150, 380), fill=(224, 206, 168))
        for i, letter in enumerate(text):
            d.text((x + 75, 84 + i * 56), letter, fill=(252, 244, 220), font=ImageFont.load_default(52), anchor="mm")
    for x in (270, 560, 960):
        d.polygon((x - 26, 408, x + 26, 408, x + 18, H, x - 18, H), fill=(176, 92, 60))
        for a in np.linspace(-1.3, 1.3, 9):
            tip = (x + 90 * np.sin(a), 408 - 140 * np.cos(a))
            d.polygon((x - 6, 408, x + 6, 408, *tip), fill=(36, 116 + int(30 * np.cos(3 * a)), 60))
    for x, tall, coat in ((520, 235, (200, 70, 110)), (630, 250, (70, 90, 120)), (690, 150, (240, 150, 60))):
        _visitor(d, x, tall, coat, (70, 46, 30))
    return np.asarray(image)
