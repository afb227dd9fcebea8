"""The player's time: it never goes back, even if the time of day was set while a robot was recorded. No Django."""

LONGEST_NS = 3600 * 10**9  # a recorded robot is never silent for longer: then the time of day was set ahead
LATE_NS = 15 * 10**9  # a message may be so much older than the one before; more: the time of day was set back
AHEAD, BACK = "The time of day was set ahead by {} here.", "The time of day was set back by {} here."
LENGTHS = (
    (86_400, "about 1 day", "about {} days"), (3600, "about 1 hour", "about {} hours"),
    (60, "about 1 minute", "about {} minutes"), (1, "about 1 second", "about {} seconds"),
)  # fmt: skip


class Axis:
    """Turns the times of messages, in the order of the file, into ns since the first."""

    def __init__(self, newest_ns: int | None = None, at_ns: int = 0) -> None:
        self.newest_ns, self.at_ns = newest_ns, at_ns
        self.set_ns = 0  # by how much the time of day was set before the newest message

    def place(self, time_ns: int) -> int:
        """Return where a message is, in ns since the first."""
        passed = 0 if self.newest_ns is None else time_ns - self.newest_ns
        self.set_ns = 0 if -LATE_NS <= passed <= LONGEST_NS else passed
        if self.newest_ns is None or self.set_ns:
            self.newest_ns = time_ns
        elif passed > 0:
            self.newest_ns, self.at_ns = time_ns, self.at_ns + passed
        return self.at_ns


def words_of(set_ns: int) -> str:
    """Return a sentence that says by how much the time of day was set."""
    seconds = round(abs(set_ns) / 10**9)
    said = AHEAD if set_ns > 0 else BACK
    for length, one, many in LENGTHS:
        if seconds >= length:
            count = round(seconds / length)
            return said.format(one if count == 1 else many.format(count))
    return said.format("less than a second")
