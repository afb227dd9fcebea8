"""A recording of Mercury whose pictures tell the second that they are of."""

import cv2
import numpy as np
import pytest

from robots.kit.clock import SYSTEM
from robots.kit.contract.session import RobotState
from robots.kit.packets import picture_packet, state_packet
from robots.kit.recording.container import Tape
from robots.kit.recording.packets import picture_of, state_told
from robots.models import RecordingState
from robots.recordings import keeping

SECONDS = 24
NAMES = ("q1", "q2", "q3", "q4")


def grey(second):
    return 10 * second


def jpeg(level):
    return cv2.imencode(".jpg", np.full((165, 192), level, np.uint8))[1].tobytes()


@pytest.fixture
def recording(portal):
    """Half a minute of a turn: each second the picture is brighter; a command at 5 s that fails at 8 s."""
    ada = portal.person("ada", "mercury")
    turn = portal.drive(ada, "mercury")
    portal.end(turn)
    row = keeping.begin(turn.grant, "here", SYSTEM.now())
    path, began = keeping.path_of(row), int(row.began_at.timestamp() * 1000)
    path.parent.mkdir(parents=True, exist_ok=True)
    tape = Tape(path, {})
    stages = {5000: ("queued", ""), 8000: ("failed", "It slipped.")}
    for tick in range(SECONDS * 4):
        ms, second = began + 250 * tick, tick // 4
        if tick % 8 == 7:
            tape.flush()  # as the recorder does
        state = RobotState(0.0, (0.1 * second, 1.8, 0.0, 0.0), (), False, True, mode=f"second {second}")
        tape.put("state", ms * 10**6, state_told(state_packet(tick, ms, state, False), NAMES, ()))
        if tick % 4 == 0:
            tape.put("camera/0", ms * 10**6, picture_of(picture_packet(second, ms, 0, (), jpeg(grey(second)))))
        if (ms - began) in stages:
            stage, reason = stages[ms - began]
            told = {"id": 7, "seq": 1, "grant": turn.grant_id, "kind": "down", "state": stage, "reason": reason,
                    "at_ms": ms, "result": {}, "progress": {}}  # fmt: skip
            tape.put("commands", ms * 10**6, told)
    tape.close()
    keeping.finish(row, RecordingState.READY, "", SYSTEM.now())
    row.turn = turn
    return row
