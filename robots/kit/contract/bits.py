"""Reads packets that are one big-endian number, bit by bit."""


class BitReader:
    """The bits of `data` from the bit number `begin` on, the highest first; `left` counts those that are left."""

    def __init__(self, data: bytes, begin: int) -> None:
        self._number, self.left = int.from_bytes(data, "big"), 8 * len(data) - begin

    def take(self, count: int) -> int:
        """Return the next so many bits as a number. Raises ValueError: there are fewer."""
        if count > self.left:
            raise ValueError("the end is missing")
        self.left -= count
        return self._number >> self.left & (1 << count) - 1

    @property
    def rest(self) -> int:
        """Return what is left as a number."""
        return self._number & (1 << self.left) - 1
