"""Pictures in the rover's firmware: it encodes them, measures in them, and answers with the results.

Letters that would alter the pictures (`g`, `o`) are confirmed elsewhere and alter nothing here.
"""

from collections.abc import Callable

import cv2
import numpy as np

from robots.kit.clock import Timer
from robots.kit.drivers.srv1.protocol import SIZES, PictureHeader, Size
from simulators.common.rovers import views
from simulators.srv1.frame import Bin, Frame, Image
from simulators.srv1.hardware import Hardware
from simulators.srv1.uart import Uart

QUALITY, WORST = 4, 8  # at first, and the last of them; 1 is the best
THRESHOLD = 3200  # of an edge, at first
BINS = 25  # of colours: as many as a letter can name
RESIZE_S, PICTURE_S = 0.05, 0.02
AXIS = b"      0  16  32  48  64  80  96 112 128 144 160 176 192 208 224 240 (V-axis)\r\n"
MARKS = (2, b"****"), (5, b" ***"), (8, b"  **"), (11, b"   *")  # above a part of all pairs: a power of two
UNEVEN = (0, 95), (96, 127), (128, 159), (160, 255)  # ranges of U and V that are finer in the middle
ALL = 0, 255


def jpeg(picture: Image, quality: int = QUALITY) -> bytes:
    """Return a picture (RGB) as JPEG of a quality from 1 to 8, with the tables of the firmware's encoder.

    The firmware multiplies the standard's tables by (3 * quality - 2) / 8; libjpeg counts their size otherwise.
    """
    size = (3 * quality - 2) / 8
    same = round(50 / size if size > 1 else 100 - 50 * size)
    return views.jpeg(picture, same, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422)


class Imaging:
    """`letters`: what each does; it returns its answer. A busy camera has no picture, and no answer."""

    def __init__(self, hardware: Hardware, uart: Uart, clock: Timer) -> None:
        self._hardware, self._uart, self._clock = hardware, uart, clock
        self.letters: dict[str, Callable[[], bytes]] = {
            "I": self._picture, "q": self._set_quality, "T": self._set_threshold, "v": self._vision,
            "y": lambda: self._turn(True), "Y": lambda: self._turn(False),
        }  # fmt: skip
        self.letters |= {size.letter.decode(): self._resizes(size) for size in SIZES}
        self.letters["A"] = self.letters["d"]
        self._commands: dict[str, Callable[[], bytes]] = {
            "a": lambda: b"##va%d\r\n" % (uart.argument() & 7), "b": self._blobs, "c": self._set_bin,
            "d": lambda: b"##vdump\r\n" + b"".join(b"%x 0\r\n" % register for register in range(256)),
            "f": self._count, "h": self._histogram, "m": self._mean, "p": self._pixel, "r": self._recall,
            "s": lambda: self._scan(b"##vscan", from_below=True), "t": self._threshold_of_four,
            "u": lambda: self._scan(b"##vhorizon", from_below=False), "z": self._segment,
        }  # fmt: skip
        self.restart()

    def restart(self) -> None:
        """Begin as at power on."""
        self.size: Size = SIZES[1]
        self._quality, self._threshold, self._upside_down = QUALITY, THRESHOLD, False
        self._bins = [Bin()] * BINS

    def _seen(self) -> Image | None:
        taken = self._hardware.picture(self.size.width)
        self._clock.sleep(PICTURE_S)  # a hold does not cut a picture off
        return np.ascontiguousarray(taken[::-1, ::-1]) if taken is not None and self._upside_down else taken

    def _picture(self) -> bytes:
        taken = self._seen()
        if taken is None:
            return b""
        data = jpeg(taken, self._quality)
        header, faults = PictureHeader(self.size, len(data)), self._hardware.faults
        if faults.take("lying_length"):
            header = PictureHeader(self.size, 0xFFFFFF00)
        if faults.take("half_frame"):
            data = data[: len(data) // 2]
        return header.encode() + data

    # settings

    def _resizes(self, size: Size) -> Callable[[], bytes]:
        def resize() -> bytes:
            self.size = size
            self._uart.delay(RESIZE_S)
            return b"#" + size.letter

        return resize

    def _turn(self, upside_down: bool) -> bytes:
        self._upside_down = upside_down
        return b"#y" if upside_down else b"#Y"

    def _set_quality(self) -> bytes:
        asked = self._uart.argument()
        self._quality = min(WORST, max(1, asked & 15))
        return b"##quality - %c\r\n" % asked

    def _set_threshold(self) -> bytes:
        self._threshold = (self._uart.argument() & 15) * 800
        return b"#T"

    # `v`

    def _vision(self) -> bytes:
        command = self._commands.get(chr(self._uart.argument()))
        return b"" if command is None else command()

    def _number(self, digits: int) -> int:
        number = 0
        for _ in range(digits):
            number = number * 10 + (self._uart.argument() & 15)
        return number

    def _index(self) -> tuple[int, int]:
        """Return the letter that names a range of colours, and which that is."""
        letter = self._uart.argument()
        return letter, (letter & 15) + (9 if letter > ord("9") else 0)

    def _measured(self, answer: Callable[[Frame], bytes]) -> bytes:
        taken = self._seen()
        return b"" if taken is None else answer(Frame(taken))

    def _blobs(self) -> bytes:
        letter, index = self._index()

        def answer(frame: Frame) -> bytes:
            found = frame.blobs(self._bins[index])
            rows = (b" %d - %d %d %d %d  \r\n" % (b.count, b.x1, b.x2, b.y1, b.y2) for b in found)
            return b"##vb%c %d\r\n" % (letter, len(found)) + b"".join(rows)

        return self._measured(answer)

    def _set_bin(self) -> bytes:
        _, index = self._index()
        self._bins[index] = Bin(*[self._number(3) for _ in Bin()])
        return b"##vc %d\r\n" % index

    def _recall(self) -> bytes:
        _, index = self._index()
        return b"##vr %d %d %d %d %d %d %d\r\n" % (index, *self._bins[index])

    def _count(self) -> bytes:
        of = self._bins[self._uart.argument() & 15]
        x1, x2, y1, y2 = [self._number(4) for _ in range(4)]
        return self._measured(lambda frame: b"##vf %d\r\n" % frame.count(of, x1, x2, y1, y2))

    def _mean(self) -> bytes:
        return self._measured(lambda frame: b"##vmean %d %d %d\r\n" % frame.mean())

    def _pixel(self) -> bytes:
        x, y = self._number(4), self._number(4)
        return self._measured(lambda frame: b"##vp %d %d %d\r\n" % frame.pixel(x, y))

    def _histogram(self) -> bytes:
        def answer(frame: Frame) -> bytes:
            pairs, counts = frame.u.size, frame.histogram()
            marks = [[next((m for by, m in MARKS if n > pairs >> by), b"    ") for n in row] for row in counts.tolist()]
            rows = b"".join(b"%d%b\r\n" % (16 * at, b"".join(row)) for at, row in enumerate(marks))
            regions = sum(mark.strip() != b"" for row in marks for mark in row)
            return b"##vhist\r\n" + AXIS + rows + b"(U-axis)             %d regions\r\n" % regions

        return self._measured(answer)

    def _scan(self, head: bytes, from_below: bool) -> bytes:
        columns = self._uart.argument() & 15

        def answer(frame: Frame) -> bytes:
            rows, pairs = np.nonzero(frame.edges(self._threshold))
            column = pairs * 2 * columns // frame.width
            ends = [rows[column == at] for at in range(columns)]
            if from_below:
                found = [frame.height - int(end.max(initial=0)) for end in ends]
            else:
                found = [int(end.min()) if len(end) else 0 for end in ends]
            return head + b" = %d %b\r\n" % (len(rows), b"".join(b"%4d " % one for one in found))

        return self._measured(answer)

    def _threshold_of_four(self) -> bytes:
        self._threshold = self._number(4)
        return b"##vthresh %d\r\n" % self._threshold

    def _segment(self) -> bytes:
        """Empty all ranges of colours, or divide all colours among the first 16."""
        kinds: dict[int, Callable[[int], Bin]] = {
            0: lambda _: Bin(),
            1: lambda n: Bin(*_part(n >> 2, 64), *_part(n >> 1 & 1, 128), *_part(n & 1, 128)),
            2: lambda n: Bin(*ALL, *_part(n >> 2, 64), *_part(n & 3, 64)),
            3: lambda n: Bin(*ALL, *UNEVEN[n >> 2], *UNEVEN[n & 3]),
            4: lambda n: Bin(*_part(n, 16), *ALL, *ALL),
        }  # fmt: skip
        kind = kinds.get(self._uart.argument() & 15)
        if kind is not None:
            self._bins[:16] = [kind(n) for n in range(16)]
        return b"##vzero\r\n"


def _part(number: int, size: int) -> tuple[int, int]:
    """Return the bounds of a range of a colour where all ranges are of one size."""
    return number * size, number * size + size - 1
