"""What the recorder keeps of a command whose end it learns twice: from its row, and later from the bus."""

import json
from types import SimpleNamespace

from robots.kit.packets import CommandStage
from workers.recorder.recorder import Recorder


def test_the_end_of_a_command_is_recorded_once():
    kept = []
    one = SimpleNamespace(
        stages={7: "queued"}, taping=SimpleNamespace(tell=lambda topic, at_ns, data: kept.append(data))
    )
    recorder = Recorder()
    for state in ("acknowledged", "completed", "accepted", "acknowledged", "completed"):
        recorder._tell_command(one, CommandStage(7, 1, 3, "up", state))
    assert [json.loads(data)["state"] for data in kept] == ["acknowledged", "completed"]
