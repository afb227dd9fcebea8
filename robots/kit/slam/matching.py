"""Compares a view with all templates: exactly the best one, most of them ruled out without a look at their pixels.

The difference of two views is the sum of absolute differences (SAD) over the columns that both have at a given
shift. A sum of absolute differences is never less than the absolute difference of the sums, over the whole or over
each row. So the sums of each template's rows, kept for each shift, rule out a template that cannot be the best.
"""

import numpy as np
from numpy.typing import NDArray

from robots.kit.compiled import compiled

Grey = NDArray[np.uint8]
Sums = NDArray[np.int32]


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
    changes the speed and never the answer. Shapes: view (height, width), templates (n, height, width), rows
    (n, 2 shift + 1, height), totals (n, 2 shift + 1); the first `count` of them count.
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
