"""rosbridge_server by its conversion rules, in front of `tests.ros_fake`; written from what rosbridge_suite does.

Of rosbridge_library (branches ros1 and ros2): a field that the type does not have, or a value of another type, drops the
message with a status; a header is stamped on arrival before its fields are read; NaN and infinities become null, but
not in the arrays of fixed size that ROS 2 keeps in NumPy; arguments are an object, a list, or nothing; ROS 2 calls
services one after another in the connection's thread unless it is told otherwise.
"""

import base64
import json
import math
import threading

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import serve

from tests.ros_fake import PRIMITIVE, TIMES, WHOLE


class Mismatch(Exception):
    """A message that does not fit its type."""


def populate(ros, found, message):
    """Set the message's fields from JSON."""
    if not isinstance(found, dict):
        raise Mismatch(f"Expected a JSON object for type {message.kind} but received a {type(found)}")
    if message.kind == "std_msgs/Header":
        message.stamp = ros.now()
    fields = dict(message.fields)
    for name, value in found.items():
        if name not in fields:
            raise Mismatch(f"Message type {message.kind} does not have a field {name}")
        object.__setattr__(message, name, converted(ros, value, fields[name], getattr(message, name)))
    return message


def converted(ros, value, kind, present):
    if kind in TIMES:
        for name, _ in present.fields:
            older = {"sec": "secs", "nanosec": "nsecs"}.get(name)
            if (said := name if name in value else older) in value:
                setattr(present, name, value[said])
        return present
    if kind.startswith("uint8["):
        return list(base64.b64decode(value)) if isinstance(value, str) else value
    if "[" in kind:
        return [converted(ros, part, kind.split("[")[0], None) for part in value]
    if kind in PRIMITIVE or WHOLE.fullmatch(kind):
        wanted = PRIMITIVE.get(kind, int)
        if wanted is float and type(value) is int:
            value = float(value)
        if type(value) is not wanted:
            raise Mismatch(f"message requires a {kind}, but got a {type(value)}")
        return value
    return populate(ros, value, present or ros.message(kind)())


def extracted(ros, value, kind):
    """Return a message's field as JSON."""
    if kind.startswith("uint8["):
        return base64.b64encode(bytes(value)).decode()
    if "[" in kind:
        if ros.version == 2 and kind[kind.index("[") + 1 : -1]:
            return list(value)
        return [extracted(ros, part, kind.split("[")[0]) for part in value]
    if kind in ("float32", "float64"):
        return value if math.isfinite(value) else None
    if kind in PRIMITIVE or WHOLE.fullmatch(kind):
        return value
    return {name: extracted(ros, getattr(value, name), part) for name, part in value.fields}


class Bridge:
    """Serves one graph at `address`."""

    def __init__(self, ros):
        self._ros = ros
        self._server = serve(self._talk, "127.0.0.1", 0, compression=None)
        self.address = f"127.0.0.1:{self._server.socket.getsockname()[1]}"
        self.said = []  # status messages to clients about their frames
        self.kept_back = None  # a list: what clients publish waits in it, as topics and services are not ordered
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def close(self):
        self._server.shutdown()

    def _talk(self, line):
        try:
            for data in line:
                found = json.loads(data)
                try:
                    getattr(self, f"_{found['op']}")(line, found)
                except Exception as error:
                    self.said.append(str(error))
                    self._send(line, op="status", level="error", msg=f"{found['op']}: {error}", id=found.get("id"))
        except ConnectionClosed:
            pass

    def _send(self, line, **frame):
        try:
            line.send(json.dumps(frame))
        except ConnectionClosed:
            return

    def _subscribe(self, line, found):
        topic = found["topic"]
        kind = self._ros.message(found["type"].replace("/msg/", "/"))

        def bridged(message):
            self._send(line, op="publish", topic=topic, msg=extracted(self._ros, message, message.kind))

        self._ros.listen(topic, kind, bridged)

    def _unsubscribe(self, line, found):
        pass

    def _publish(self, line, found):
        kind = self._ros.kinds.get(found["topic"])
        if kind is None:
            raise Mismatch(f"Cannot infer topic type for topic {found['topic']} as it is not yet advertised")
        message = populate(self._ros, found["msg"], kind())
        if self.kept_back is not None:
            self.kept_back.append((found["topic"], message))
        else:
            self._ros.publish(found["topic"], message)

    def deliver(self, order=1):
        """Publish what was kept back, by -1 the newest first."""
        kept, self.kept_back = self.kept_back, None
        for topic, message in kept[::order]:
            self._ros.publish(topic, message)

    def _call_service(self, line, found):
        if self._ros.version == 1:
            threading.Thread(target=self._called, args=(line, found), daemon=True).start()
        else:
            self._called(line, found)

    def _called(self, line, found):
        answer = {"op": "service_response", "service": found["service"]} | (
            {"id": found["id"]} if found.get("id") is not None else {}
        )
        try:
            request, serve_one = self._ros.services[found["service"]]
            args, wanted = found.get("args"), request()
            if isinstance(args, list):
                args = dict(zip([name for name, _ in wanted.fields], args, strict=False))
            response = serve_one(populate(self._ros, args if isinstance(args, dict) else {}, wanted))
            self._send(line, **answer, values=extracted(self._ros, response, response.kind), result=True)
        except Exception as error:
            self._send(line, **answer, values=str(error), result=False)
