"""The file that tells the supervisor that the owner lives."""

import contextlib
from pathlib import Path

from workers.robot.owned import OwnedRobot

TOUCH_S = 0.5


class Heartbeat:
    """Touches the file in a thread of its own while `beat` is called again and again.

    So a disk that stalls does not delay the watch, which holds the robot.
    """

    def __init__(self, owned: OwnedRobot, file: Path) -> None:
        self._owned, self._file = owned, file
        self._beats = 0

    def beat(self) -> None:
        """Note that the watch goes round and every lane is sound."""
        self._beats += 1

    def loop(self) -> None:
        """Touch the file for the beats of the last while, until the owner ends."""
        told = 0
        while self._owned.running:
            if (beats := self._beats) != told:
                with contextlib.suppress(OSError):
                    self._file.touch()
                told = beats
            self._owned.clock.sleep(TOUCH_S)
