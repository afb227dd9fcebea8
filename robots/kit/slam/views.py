"""View templates: pictures that the robot has seen, small and grey, and their comparison with a view.

The comparison finds exactly the best template, and rules most of them out without a look at their pixels. The
difference of two views is the sum of absolute differences (SAD) over the columns that both have at a given shift. A sum
of absolute differences is never less than the absolute difference of the sums, over the whole or over each row. So the
sums of each template's rows, which are stored for each shift, rule out a template that cannot be the best.
"""

from secrets import token_hex

import cv2
import numpy as np
from numpy.typing import NDArray

from robots.kit.compiled import compiled
from robots.kit.slam.settings import ViewSettings

Grey = NDArray[np.uint8]
Sums = NDArray[np.int32]
LARGEST_BYTES = 1_000_000  # of a JPEG


def decoded(jpeg: bytes) -> Grey:
    """Return the grey picture of a JPEG, (height, width). Raises ValueError if it is none or too large."""
    if not 0 < len(jpeg) <= LARGEST_BYTES:
        raise ValueError(f"a picture of {len(jpeg)} bytes is not used; 1 to {LARGEST_BYTES} are.")
    picture = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
    if picture is None:
        raise ValueError("the picture could not be decoded as JPEG.")
    return np.asarray(picture, np.uint8)


class Views:
    """All templates, each an 8-bit grey picture of the settings' size.

    `decay`, (n,): what weakens the injection of each. `places`, (n, 3): x, y, heading in cells where each was first
    seen. `mark`: the name of this numbering; `stored_count`: how many are in the file of that name (see storage.py).
    """

    def __init__(self, settings: ViewSettings) -> None:
        self.settings, self.count = settings, 0
        self.mark, self.stored_count = token_hex(8), 0
        self._room(64)

    def _room(self, many: int) -> None:
        settings, old = self.settings, self.count
        shifts = 2 * settings.shift + 1
        for name, shape, kind in (
            ("templates", (settings.height, settings.width), np.uint8),
            ("rows", (shifts, settings.height), np.int32),
            ("totals", (shifts,), np.int32),
            ("decay", (), np.float64),
            ("places", (3,), np.float64),
        ):
            grown = np.zeros((many, *shape), kind)
            if old:
                grown[:old] = getattr(self, name)[:old]
            setattr(self, name, grown)

    templates: Grey
    rows: NDArray[np.int32]
    totals: NDArray[np.int32]
    decay: NDArray[np.float64]
    places: NDArray[np.float64]

    def view(self, picture: Grey) -> Grey:
        """Return the part of a grey picture that is compared, in the size of a template.

        Raises ValueError if the picture is no 8-bit grey one or smaller than a template.
        """
        settings = self.settings
        if picture.ndim != 2 or picture.dtype != np.uint8:
            raise ValueError(f"a grey picture of 8 bits is needed, not {picture.dtype} of shape {picture.shape}.")
        part = picture[settings.top : settings.bottom]
        if part.shape[0] < settings.height or part.shape[1] < settings.width:
            raise ValueError(f"the picture {picture.shape} is smaller than a template.")
        return np.asarray(cv2.resize(part, (settings.width, settings.height), interpolation=cv2.INTER_AREA), np.uint8)

    def match(self, view: Grey, guess: int = -1) -> tuple[int, float]:
        """Return (number, difference) of the nearest template within the threshold; number -1 if there is none."""
        settings = self.settings
        full = 255 * settings.height * (settings.width - 2 * settings.shift)
        limit = int(settings.match * full)
        number, found = best(view, self.templates, self.rows, self.totals, self.count, settings.shift, limit, guess)
        return int(number), float(found) / full

    def add(self, view: Grey, place: tuple[float, float, float], decay: float) -> int:
        """Store a new template, seen at the place (x, y, heading in cells), and return its number."""
        if self.count == len(self.templates):
            self._room(2 * self.count)
        n, self.count = self.count, self.count + 1
        self.templates[n], self.places[n], self.decay[n] = view, place, decay
        row_sums(self.templates[n], self.settings.shift, self.rows[n], self.totals[n])
        return n

    def keep(self, numbers: NDArray[np.int64]) -> None:
        """Keep only the templates of these numbers, ascending; they are numbered anew in this order."""
        for array in (self.templates, self.rows, self.totals, self.decay, self.places):
            array[: len(numbers)] = array[numbers]
        self.count = len(numbers)
        self.mark, self.stored_count = token_hex(8), 0

    def restore(self, templates: Grey, mark: str) -> None:
        """Take these templates, which stand in the file of that name; the caller fills in decay and places."""
        self.count, self.mark, self.stored_count = 0, mark, len(templates)
        self._room(max(64, len(templates)))
        for template in templates:
            self.add(template, (0.0, 0.0, 0.0), 0.0)


@compiled
def row_sums(view: Grey, shift: int, rows: Sums, totals: Sums) -> None:
    """Write the sums of a template's rows, (2 shift + 1, height), and of the whole, (2 shift + 1,), at each shift."""
    height, width = view.shape
    span = width - 2 * shift
    for s in range(2 * shift + 1):
        total = 0
        for h in range(height):
            line = 0
            for c in range(span):
                line += view[h, s + c]
            rows[s, h] = line
            total += line
        totals[s] = total


@compiled
def _row(a: Grey, b: Grey) -> np.uint32:
    """Return the SAD of two rows of one length."""
    found = np.uint32(0)
    for c in range(a.size):
        found = np.uint32(found + np.uint32(abs(np.int32(a[c]) - np.int32(b[c]))))
    return found


@compiled
def best(
    view: Grey, templates: Grey, rows: Sums, totals: Sums, count: int, shift: int, limit: int, guess: int
) -> tuple[int, int]:
    """Return (number, SAD) of the template of least difference, the lowest number among equals.

    Templates beyond `limit` do not count: (-1, limit + 1) if none is within. `guess`: the one to look at first, which
    changes the speed and never the answer.

    Shapes: view (height, width), templates (n, height, width), rows (n, 2 shift + 1, height), totals (n, 2 shift + 1);
    the first `count` templates are compared.
    """
    height, width = view.shape
    span = width - 2 * shift
    middle = np.ascontiguousarray(view[:, shift : shift + span])
    view_rows = np.zeros(height, np.int32)
    view_total = 0
    for h in range(height):
        for c in range(span):
            view_rows[h] += middle[h, c]
        view_total += view_rows[h]
    found, least = -1, int(limit) + 1
    first = guess if 0 <= guess < count else 0
    for k in range(count):
        n = first if k == 0 else (k - 1 if k <= first else k)
        # the most that would still make n the answer
        most = least if n < found else least - 1
        for s in range(2 * shift + 1):
            if abs(view_total - totals[n, s]) > most:
                continue
            rest = 0
            for h in range(height):
                rest += abs(view_rows[h] - rows[n, s, h])
            if rest > most:
                continue
            total = 0
            for h in range(height):
                rest -= abs(view_rows[h] - rows[n, s, h])
                total += int(_row(middle[h], templates[n, h, s : s + span]))
                if total + rest > most:
                    break
            if total + rest <= most:  # after the last row nothing is left of the rest
                found, least, most = n, total, total - 1
    return found, least
