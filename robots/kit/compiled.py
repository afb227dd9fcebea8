"""Compiles loops with numba, and keeps the compiled code between runs where a folder can be written."""

from collections.abc import Callable
from typing import Any, TypeVar

import numba

Loop = TypeVar("Loop", bound=Callable[..., Any])


def compiled(loop: Loop) -> Loop:
    """Return the function compiled at its first call, without the interpreter's lock while it runs.

    The code is stored beside the source, or else in the user's cache folder; if neither is possible, each process
    compiles it anew.
    """
    try:
        made: Loop = numba.njit(loop, cache=True, nogil=True)
    except RuntimeError:  # no folder to keep it in
        made = numba.njit(loop, nogil=True)
    return made
