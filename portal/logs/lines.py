"""The format of log lines: time (UTC), level, source, message; without the secrets of addresses."""

import logging
import time

from robots.addresses import redacted


class Line(logging.Formatter):
    """Formats a record as one line; text from strangers cannot start a new line. Tracebacks keep their lines."""

    converter = time.gmtime  # type: ignore[assignment]
    default_time_format = "%Y-%m-%dT%H:%M:%S"
    default_msec_format = "%s.%03dZ"

    def format(self, record: logging.LogRecord) -> str:
        """Return the line and its traceback without the passwords of addresses, which libraries put into errors."""
        return redacted(super().format(record))

    def formatMessage(self, record: logging.LogRecord) -> str:
        """Return the line with control characters escaped."""
        line = super().formatMessage(record)
        return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in line)
