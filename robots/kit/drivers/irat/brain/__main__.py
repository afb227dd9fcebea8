"""The brain as a process: ``python -m robots.kit.drivers.irat.brain FOLDER``; it ends with the pipe from its parent."""

import contextlib
import logging
import os
import sys
from pathlib import Path

import cv2

from robots.kit.drivers.irat.brain.messages import frame, read, to_brain
from robots.kit.drivers.irat.brain.mind import Mind
from robots.kit.slam.slam import compile_loops


def main() -> None:
    """Answer until the parent closes the pipe."""
    logging.basicConfig(level=logging.INFO, format="irat brain: %(message)s")
    cv2.setNumThreads(1)
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # the output of libraries must not look like an answer
    compile_loops()  # before the first answer, without which the robot is not ready
    mind = Mind(Path(sys.argv[1]))
    with contextlib.suppress(BrokenPipeError, KeyboardInterrupt):
        while (data := read(sys.stdin.buffer)) is not None:
            for answer in mind.take(to_brain.decode(data)):
                out.write(frame(answer))
            out.flush()
    mind.save()


if __name__ == "__main__":
    main()
