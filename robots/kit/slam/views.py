"""View templates: pictures that the robot has seen, small and grey."""

from secrets import token_hex

import cv2
import numpy as np
from numpy.typing import NDArray

from robots.kit.slam import matching
from robots.kit.slam.settings import ViewSettings

Grey = NDArray[np.uint8]
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

    `decay`, (n,): how tired each is of injecting. `places`, (n, 3): x, y, heading in cells where each was first seen.
    `mark`: the name of this numbering; `stored`: how many are in the file of that name (see storage.py).
    """

    def __init__(self, settings: ViewSettings) -> None:
        self.settings, self.count = settings, 0
        self.mark, self.stored_count = token_hex(8), 0
        self._room(64)

    def _room(self, many: int) -> None:
        kept, old = self.settings, self.count
        shifts = 2 * kept.shift + 1
        for name, shape, kind in (
            ("templates", (kept.height, kept.width), np.uint8),
            ("rows", (shifts, kept.height), np.int32),
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
        kept = self.settings
        if picture.ndim != 2 or picture.dtype != np.uint8:
            raise ValueError(f"a grey picture of 8 bits is needed, not {picture.dtype} of shape {picture.shape}.")
        part = picture[kept.top : kept.bottom]
        if part.shape[0] < kept.height or part.shape[1] < kept.width:
            raise ValueError(f"the picture {picture.shape} is smaller than a template.")
        return np.asarray(cv2.resize(part, (kept.width, kept.height), interpolation=cv2.INTER_AREA), np.uint8)

    def match(self, view: Grey, guess: int = -1) -> tuple[int, float]:
        """Return (number, difference) of the nearest template within the threshold; number -1 if there is none."""
        kept = self.settings
        full = 255 * kept.height * (kept.width - 2 * kept.shift)
        limit = int(kept.match * full)
        number, found = matching.best(
            view, self.templates, self.rows, self.totals, self.count, kept.shift, limit, guess
        )
        return int(number), float(found) / full

    def add(self, view: Grey, place: tuple[float, float, float], decay: float) -> int:
        """Keep a new template, seen at the place (x, y, heading in cells), and return its number."""
        if self.count == len(self.templates):
            self._room(2 * self.count)
        n, self.count = self.count, self.count + 1
        self.templates[n], self.places[n], self.decay[n] = view, place, decay
        matching.row_sums(self.templates[n], self.settings.shift, self.rows[n], self.totals[n])
        return n

    def keep(self, numbers: NDArray[np.int64]) -> None:
        """Keep only these, ascending; they are numbered anew in this order."""
        for held in (self.templates, self.rows, self.totals, self.decay, self.places):
            held[: len(numbers)] = held[numbers]
        self.count = len(numbers)
        self.mark, self.stored_count = token_hex(8), 0

    def restore(self, templates: Grey, mark: str) -> None:
        """Hold these templates, which the file of that name has; decay and places are the caller's to fill."""
        self.count, self.mark, self.stored_count = 0, mark, len(templates)
        self._room(max(64, len(templates)))
        for template in templates:
            self.add(template, (0.0, 0.0, 0.0), 0.0)
