"""The iRat's brain as a process of a world; its mind takes a declared time for each picture."""

import math
from collections import deque
from collections.abc import Iterator
from pathlib import Path

from robots.kit.drivers.irat.brain.messages import Feed, FromBrain, ToBrain
from robots.kit.drivers.irat.brain.mind import Mind
from tests.world.world import Killed, World

THINKING_S, ANSWER_S = 0.04, 0.002  # for a picture, and for anything else


class Brain:
    """A `brain.child.Child`. It writes its map and ends once its owner has gone."""

    def __init__(self, world: World, folder: Path) -> None:
        self._world, self._folder, self.pid = world, folder, 0
        self._asked: deque[ToBrain] = deque()
        self._said: deque[FromBrain] = deque()
        self._left = False
        self.mind: Mind | None = None  # once it has begun

    def begin(self) -> None:
        self.process = self._world.process("brain")
        self.pid = self.process.number
        self._world.running.process.at_kill.append(self._leave)
        self._world.spawn(self._run, "mind", self.process)

    def _leave(self) -> None:
        self._left = True

    def _run(self) -> None:
        self.mind = mind = Mind(self._folder, self._world)
        while True:
            self._world.park(math.inf, lambda: self._asked or self._left)
            if not self._asked:
                break
            asked = self._asked.popleft()
            self._world.sleep(THINKING_S if isinstance(asked, Feed) and asked.jpeg else ANSWER_S)
            self._said.extend(mind.take(asked))
        mind.save()
        self.kill()
        raise Killed

    def send(self, message: ToBrain) -> None:
        if not self._left:
            self._asked.append(message)

    def answers(self) -> Iterator[FromBrain]:
        while self._world.park(math.inf, lambda: self._said or self.process.killed) and self._said:
            yield self._said.popleft()

    def kill(self) -> None:
        self._world.kill(self.process)

    def end(self, seconds: float) -> None:
        self._leave()
        if self.pid and not self._world.park(self._world.monotonic() + seconds, lambda: self.process.killed):
            self.kill()
