"""Writes a file so that readers see the old or the new content, never a part."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO


@contextlib.contextmanager
def beside(path: Path, part: Path) -> Iterator[Path]:
    """Let the file `part`, on the same disk, replace `path` after it was written; an error removes it.

    Raises OSError; the old file stays then.
    """
    try:
        yield part
        part.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
        raise


@contextlib.contextmanager
def replaced(path: Path, sync: bool = False) -> Iterator[BinaryIO]:
    """Open a file that replaces `path` after it was written without an error.

    `sync`: the content is on the disk before the replacement. Raises OSError; the old file stays then.
    """
    with beside(path, path.with_suffix(".part")) as part, part.open("wb") as out:
        yield out
        if sync:
            out.flush()
            os.fsync(out.fileno())


def replace_text(path: Path, text: str) -> None:
    """Write a short text so that readers see the old or the new one. Raises OSError; the old file stays then."""
    with replaced(path) as out:
        out.write(text.encode())
