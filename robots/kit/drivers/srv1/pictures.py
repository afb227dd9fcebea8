"""Pictures over the rover's line: of the largest size that the line carries in time; none where it is too slow."""

from robots.kit.contract.errors import HardwareFault
from robots.kit.description import load
from robots.kit.drivers.srv1.line import RoverLine
from robots.kit.drivers.srv1.protocol import SIZES, Size, confirms

SMALL, LARGE = SIZES[0], SIZES[1]
NONE = "without pictures: the line is too slow for them"


class Pictures:
    """The pictures of one rover. Any thread may take one."""

    def __init__(self, line: RoverLine) -> None:
        limits = load("srv1")["line"]
        self._line, self._large_s, self._small_s = line, float(limits["large_s"]), float(limits["small_s"])
        self.missed_count = 0  # pictures that were requested and did not come

    @property
    def size(self) -> Size | None:
        """Return the size that the line carries in time, judged by how long a status takes; None: no picture at all."""
        if self._line.answer_s > self._small_s:
            return None
        return SMALL if self._line.answer_s > self._large_s else LARGE

    def take(self, seconds: float) -> bytes | None:
        """Return the next picture; None if none comes in so many seconds, or the line is lost or too slow for any."""
        size = self.size
        if size is None:
            return None
        taken = None
        try:
            if self._line.size is not size:
                self._line.letters(size.letter, confirms(size.letter))
            taken = self._line.picture(seconds)
        except HardwareFault:
            pass
        self.missed_count += taken is None
        return taken
