"""Why a port, a device or a connection could not be opened, and what to do, in plain words. It names no address."""

import errno
import grp
import socket
import termios
from collections.abc import Iterator
from pathlib import Path

from robots.kit.contract.errors import why

UNKNOWN_NAME = -1  # no number of the system's
BUSY = frozenset({errno.EBUSY, errno.EAGAIN, errno.ETXTBSY})  # of a device
ABSENT = "there is no such device. Plug in its cable and switch it on, or correct its address."
DANGLING = "its address is a link to a device that is not there. Plug in its cable and switch it on."
FORBIDDEN = "the portal may not open it. Add the portal's user to the group {}, then start the portal again."
NO_GROUP = "the portal may not open it. Give the portal's user the right to read and write it."
IN_USE = "another program uses it. End that program (often ModemManager or a terminal); it is tried again by itself."
NO_TTY = "what stands at its address is no serial port. Correct its address."
REFUSED = "nothing listens there. Start its program, or correct the port in its address."
NO_ROUTE = "no way leads there. Look whether it is switched on and in the network, or correct its address."
SILENT = "nothing answers there. Look whether it is switched on and in the network, or correct its address."
NO_NAME = "the name in its address is not known in the network. Correct it, or write four numbers instead."
LOST = (
    "no connection was made. Look whether it is switched on and its name known in the network, or correct its address."
)
WRONG = "its address cannot be used. Correct it; a port is a number up to 65535."
BROKEN = "the device does not work any more. Pull out its cable, and plug it in again."
WORDS = {
    errno.ECONNREFUSED: REFUSED, errno.EHOSTUNREACH: NO_ROUTE, errno.ENETUNREACH: NO_ROUTE, errno.EHOSTDOWN: NO_ROUTE,
    errno.ENETDOWN: NO_ROUTE, errno.ETIMEDOUT: SILENT, UNKNOWN_NAME: NO_NAME,
}  # fmt: skip
OF_DEVICE = WORDS | {
    errno.ENOENT: ABSENT, errno.ENOTTY: NO_TTY, errno.EINVAL: NO_TTY, errno.EISDIR: NO_TTY,
    errno.ENXIO: BROKEN, errno.ENODEV: BROKEN, errno.EIO: BROKEN,
}  # fmt: skip
OF_CONNECTION = WORDS | {
    errno.ENOENT: REFUSED,
    errno.EIO: LOST,
    errno.EINVAL: WRONG,
    errno.EAGAIN: SILENT,
}  # as FFmpeg raises them


def why_not(error: BaseException, path: str = "", late: bool = False) -> str:
    """Return why it could not be opened, as the end of a sentence.

    `path`: of the device, or its name; empty for a connection, of which the same numbers mean something else. `late`:
    its time had run out, for which FFmpeg has many errors.
    """
    number = next(_numbers(error), 0)
    if not path:
        if late:
            return SILENT
        return OF_CONNECTION.get(number) or f"{why(error)}."
    if number in BUSY:
        return IN_USE
    if number in (errno.EACCES, errno.EPERM):
        return _forbidden(path)
    if number == errno.ENOENT and Path(path).is_symlink():
        return DANGLING
    return OF_DEVICE.get(number) or f"{why(error)}."


def is_in_use(error: BaseException) -> bool:
    """Return whether another program uses the device."""
    return next(_numbers(error), 0) in BUSY


def _numbers(error: BaseException | None) -> Iterator[int]:
    """Yield the system's numbers of an error and of those behind it, which libraries wrap."""
    seen: list[BaseException] = []  # an error that is raised again may stand behind itself
    while error is not None and error not in seen:
        seen.append(error)
        number = getattr(error, "errno", None)
        if number is None and error.args and isinstance(error, OSError | termios.error):
            number = error.args[0]
        if isinstance(error, socket.gaierror):
            yield UNKNOWN_NAME
        elif isinstance(number, int):
            yield number
        elif isinstance(error, TimeoutError):
            yield errno.ETIMEDOUT
        error = error.__cause__ or error.__context__


def _forbidden(path: str) -> str:
    try:
        about = Path(path).stat()
        name = grp.getgrgid(about.st_gid).gr_name
    except (OSError, KeyError):
        return NO_GROUP
    return FORBIDDEN.format(name) if about.st_mode & 0o060 == 0o060 and about.st_gid else NO_GROUP
