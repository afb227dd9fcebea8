"""The bytes of an arm's joints and of an object's pose as others send them over WebSocket, for the same numbers.

Both say the positions alone, with names and time. rosbridge (v2) sends what ROS' `sensor_msgs/JointState` and
`geometry_msgs/PoseStamped` hold as JSON, written here without spaces and with six decimals, which is finer than ours;
foxglove-sdk is measured at its own server.
"""

import json
import subprocess
from pathlib import Path

from websockets.sync.client import connect

from benchmarks._beside import environment

SERVER = Path(__file__).with_name("_foxglove_server.py")
DECIMALS = 6
AT = {"sec": 1_700_000_000, "nanosec": 123_456_789}


def with_head(size: int) -> int:
    """Return the bytes of a WebSocket frame from a server with so many bytes in it."""
    return size + (2 if size < 126 else 4)


def _published(topic: str, message: dict[str, object]) -> int:
    text = json.dumps({"op": "publish", "topic": topic, "msg": message}, separators=(",", ":"))
    return with_head(len(text))


def rosbridge(names: list[str], joints: list[float], place: list[float], rotation: list[float]) -> tuple[int, int]:
    """Return the bytes of the frame with the joints and of the one with the object."""
    header = {"stamp": AT, "frame_id": "base"}
    q = [round(one, DECIMALS) for one in joints]
    told = {"header": header, "name": names, "position": q, "velocity": [], "effort": []}
    x, y, z, qx, qy, qz, qw = (round(one, DECIMALS) for one in (*place, *rotation))
    pose = {"position": {"x": x, "y": y, "z": z}, "orientation": {"x": qx, "y": qy, "z": qz, "w": qw}}
    return _published("/joint_states", told), _published("/brick", {"header": header, "pose": pose})


def foxglove(names: list[str], joints: list[float], place: list[float], rotation: list[float]) -> tuple[int, int]:
    """Return the bytes of the frame with the joints and of the one with the object, by foxglove-sdk's own server."""
    told = {"names": names, "joints": joints, "place": place, "rotation": rotation}
    python = environment("foxglove") / "bin" / "python"
    with subprocess.Popen([python, SERVER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdin is not None
        assert server.stdout is not None
        server.stdin.write(json.dumps(told) + "\n")
        server.stdin.flush()
        port = int(server.stdout.readline())
        try:
            return _heard(port)
        finally:
            server.stdin.close()


def _heard(port: int) -> tuple[int, int]:
    """Subscribe to both channels and return the bytes of a message of each. Raises TimeoutError."""
    topics: dict[int, str] = {}
    sizes: dict[str, int] = {}
    with connect(f"ws://127.0.0.1:{port}/", subprotocols=["foxglove.sdk.v1"]) as socket:  # type: ignore[list-item]
        assert not socket.protocol.extensions, "its messages are compressed"
        while len(sizes) < 2:
            said = socket.recv(timeout=20)
            if isinstance(said, bytes):
                sizes[topics[int.from_bytes(said[1:5], "little")]] = with_head(len(said))
                continue
            told = json.loads(said)
            if told["op"] == "advertise":
                new = [channel["id"] for channel in told["channels"]]
                topics |= {channel["id"]: channel["topic"] for channel in told["channels"]}
                wanted = {"channels": [{"id": n} for n in new]}
                wanted |= {"subscriptions": [{"id": n, "channelId": n} for n in new]}  # as an earlier version asks
                socket.send(json.dumps({"op": "subscribe", **wanted}))
    return sizes["/joint_states"], sizes["/brick"]
