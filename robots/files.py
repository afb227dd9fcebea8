"""Write a file so that it is whole whenever it is read: beside its place first, then into it."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO


@contextlib.contextmanager
def replaced(path: Path, sync: bool = False) -> Iterator[BinaryIO]:
    """Open a file that takes the place of `path` once it was written without an error.

    `sync`: it is on the disk before it does. Raises OSError; what stood there before stays then.
    """
    part = path.with_suffix(".part")
    with part.open("wb") as out:
        yield out
        if sync:
            out.flush()
            os.fsync(out.fileno())
    part.replace(path)
