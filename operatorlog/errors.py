"""What the log refuses."""


class LogError(Exception):
    """The log refuses; the message says why."""
