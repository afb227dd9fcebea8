"""The form of a line of the log: when (UTC), how grave, who, what."""

import logging
import time


class Line(logging.Formatter):
    """One record, one line: what a stranger wrote begins no line of its own. Tracebacks keep their lines."""

    converter = time.gmtime  # type: ignore[assignment]
    default_time_format = "%Y-%m-%dT%H:%M:%S"
    default_msec_format = "%s.%03dZ"

    def formatMessage(self, record: logging.LogRecord) -> str:
        """Return the line with control characters escaped."""
        line = super().formatMessage(record)
        return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in line)
