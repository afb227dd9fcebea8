"""The format of log lines: time (UTC), level, source, message.

Lines are bounded, and have no control characters and no passwords, which addresses in the errors of libraries contain.
"""

import copy
import logging
import re
import time
import traceback
from types import TracebackType

from portal.logs.text import bounded, tidy
from robots.kit.addresses import redacted

MESSAGE = 1000  # bytes of a record's first line
TRACE = 3000  # bytes of its traceback
FRAMES = 12  # of each exception, the innermost
LINE = 400  # bytes of each line of a traceback
ExcInfo = tuple[type[BaseException], BaseException, TracebackType | None] | tuple[None, None, None]


class Line(logging.Formatter):
    """Formats a record as one line of at most `MESSAGE` bytes, a traceback as lines of at most `TRACE` bytes together.

    Text of strangers begins no line; lines of a traceback begin with two spaces.
    """

    converter = time.gmtime  # type: ignore[assignment]
    default_time_format = "%Y-%m-%dT%H:%M:%S"
    default_msec_format = "%s.%03dZ"

    def format(self, record: logging.LogRecord) -> str:
        """Return the line, and those of its traceback."""
        if record.exc_info and record.exc_text:
            record = copy.copy(record)
            record.exc_text = None  # another formatter's
        return super().format(record)

    def formatMessage(self, record: logging.LogRecord) -> str:
        """Return the line with control characters escaped."""
        return tidy(redacted(super().formatMessage(record)[: 4 * MESSAGE]), MESSAGE)

    def formatException(self, ei: ExcInfo) -> str:  # type: ignore[override]
        """Return the lines of a traceback; an exception's text has one line, whatever it contains."""
        if ei[1] is None:
            return ""
        told = traceback.TracebackException(type(ei[1]), ei[1], ei[2], limit=-FRAMES, compact=True)
        return bounded("\n".join(line for part in told.format() for line in _lines(part)), TRACE, TRACE * 2 // 3)

    def formatStack(self, stack_info: str) -> str:
        """Return the lines of a stack."""
        return bounded("\n".join(_indented(redacted(stack_info))), TRACE, TRACE * 2 // 3)


def _lines(part: str) -> list[str]:
    """Return the lines of a part of a traceback: a frame has several, of the file and its code; all else has one."""
    text = redacted(part.strip("\n")[: 4 * TRACE])
    return _indented(text if re.match(r'[ |]*File "', text) else text.replace("\n", r"\n"))


def _indented(text: str) -> list[str]:
    return [f"  {tidy(line, LINE)}" for line in text.split("\n")]
