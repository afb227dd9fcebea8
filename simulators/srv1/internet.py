"""The Internet between owner and rover in place of Wi-Fi: each piece takes its own time, none overtakes another."""

from random import Random

from robots.kit.description import load


class Internet:
    """Tells when bytes arrive; see `link.Medium`. `seed`: of the delays. Not for several threads."""

    def __init__(self, seed: int) -> None:
        self._least, self._most = (float(seconds) for seconds in load("srv1")["line"]["internet_s"])
        self._dice, self._last = Random(seed), 0.0

    def reaches(self, farther: float) -> bool:
        """See `link.Medium`."""
        return True

    def arrival(self, now: float, size: int) -> float:
        """See `link.Medium`; either way."""
        self._last = max(self._last, now + self._dice.uniform(self._least, self._most))
        return self._last
