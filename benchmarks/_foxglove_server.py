"""An arm's joints and the pose of an object by foxglove-sdk; run by the Python of an environment that has it.

The first line of the input is JSON: `names` and `joints` (rad, m), `place` (m) and `rotation` (quaternion x, y, z, w).
The answer is the port of the server, which logs both again and again until the input ends.
"""

import json
import sys
import threading
import time

from foxglove import start_server
from foxglove.channels import JointStatesChannel, PoseInFrameChannel
from foxglove.messages import JointState, JointStates, Pose, PoseInFrame, Quaternion, Timestamp, Vector3

EVERY_S = 0.1


def main() -> None:
    """Log until the input ends."""
    told = json.loads(sys.stdin.readline())
    ended = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
    arm, brick = JointStatesChannel("/joint_states"), PoseInFrameChannel("/brick")
    server = start_server(host="127.0.0.1", port=0)
    print(server.port, flush=True)
    joints = [JointState(name=name, position=q) for name, q in zip(told["names"], told["joints"], strict=True)]
    pose = Pose(
        position=Vector3(**dict(zip("xyz", told["place"], strict=True))),
        orientation=Quaternion(**dict(zip("xyzw", told["rotation"], strict=True))),
    )
    while not ended.wait(EVERY_S):
        at = Timestamp.from_epoch_secs(time.time())
        arm.log(JointStates(timestamp=at, joints=joints))
        brick.log(PoseInFrame(timestamp=at, frame_id="base", pose=pose))
    server.stop()


main()
