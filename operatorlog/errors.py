"""What the log refuses."""


class LogError(Exception):
    """The log refuses; the message says why."""


class Outdated(LogError):
    """The entry has changed since the page was made from which somebody decides."""
