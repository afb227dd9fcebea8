"""ROS as far as the node of the iRat and rosbridge_server need it: messages, topics and services in one process.

There is no ROS here. Message classes come from the package's own definitions, and from the fields of ROS 1 (Noetic) and
ROS 2 (Humble) for what it uses of others. `modules` has stand-ins for rospy or rclpy with the calls of the two nodes.
"""

import contextlib
import copy
import re
import sys
import threading
import time  # noqa: TID251 - the clock of ROS
from pathlib import Path
from types import ModuleType, SimpleNamespace

PACKAGE = Path(__file__).resolve().parents[1] / "robots" / "kit" / "drivers" / "irat" / "ros"
SCRIPTS = PACKAGE / "scripts"
COMMON = {
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist\nfloat64[36] covariance",
    "nav_msgs/Odometry": "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
    "geometry_msgs/TwistWithCovariance twist",
    "sensor_msgs/LaserScan": "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
    "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\n"
    "float32[] intensities",
    "sensor_msgs/BatteryState": "std_msgs/Header header\nfloat32 voltage\nfloat32 current\nfloat32 charge\n"
    "float32 capacity\nfloat32 design_capacity\nfloat32 percentage\nuint8 power_supply_status\nbool present",
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
    "std_msgs/Float32": "float32 data",
}
OF_VERSION = {
    1: {"std_msgs/Header": "uint32 seq\ntime stamp\nstring frame_id", "time": "int32 secs\nint32 nsecs"},
    2: {
        "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
        "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    },
}
TIMES = ("time", "builtin_interfaces/Time")
PRIMITIVE = {"bool": bool, "string": str, "float32": float, "float64": float}
WHOLE = re.compile(r"(u?)int(8|16|32|64)")


def fields_of(text):
    """Return (name, type) of each line of a definition."""
    lines = (line.split("#")[0].split() for line in text.splitlines())
    return tuple((words[1], words[0]) for words in lines if words)


class Message:
    """Base of all messages; like ROS 2's it takes only values of the right type, and no field that it does not have."""

    kind, fields, ros = "", (), None

    def __init__(self, **values):
        for name, kind in self.fields:
            object.__setattr__(self, name, self.ros.default(kind))
        for name, value in values.items():
            setattr(self, name, value)

    def __setattr__(self, name, value):
        kind = dict(self.fields).get(name)
        if kind is None:
            raise AttributeError(f"{self.kind} has no field {name}")
        wanted = PRIMITIVE.get(kind, int if WHOLE.fullmatch(kind) else None)
        if wanted is not None:
            assert type(value) is wanted, f"{self.kind}.{name} takes {kind}, not {value!r}"
            if (bits := WHOLE.fullmatch(kind)) is not None:
                low, high = (0, 2 ** int(bits[2])) if bits[1] else (-(2 ** (int(bits[2]) - 1)), 2 ** (int(bits[2]) - 1))
                assert low <= value < high, f"{self.kind}.{name} is out of range: {value}"
        object.__setattr__(self, name, value)


class Ros:
    """The graph of one robot: its topics and services. Callbacks run in the thread of whoever publishes or calls."""

    def __init__(self, version):
        self.version, self.up = version, True
        self.heard, self.kinds, self.services = {}, {}, {}
        self._classes, self._definitions = {}, {**COMMON, **OF_VERSION[version]}
        for file in PACKAGE.glob("msg/*.msg"):
            self._definitions[f"irat/{file.stem}"] = file.read_text()
        self._calls = {file.stem: file.read_text().split("---") for file in PACKAGE.glob("srv/*.srv")}
        self._calls["Trigger"] = ["", "bool success\nstring message"]
        self.complaints = []
        self.groups = {}  # of ROS 2's subscriptions

    def default(self, kind):
        if "[" in kind:
            size = kind[kind.index("[") + 1 : -1]
            return [self.default(kind.split("[")[0])] * int(size or 0)
        if kind in PRIMITIVE or WHOLE.fullmatch(kind):
            return PRIMITIVE.get(kind, int)()
        return self.message(kind)()

    def message(self, kind):
        if kind not in self._classes:
            self._classes[kind] = type(
                kind.split("/")[-1],
                (Message,),
                {"kind": kind, "fields": fields_of(self._definitions[kind]), "ros": self},
            )
        return self._classes[kind]

    def service(self, name):
        """Return the service class, and those of its request and its response."""
        for part, text in zip(("Request", "Response"), self._calls[name], strict=True):
            self._definitions.setdefault(f"srv/{name}_{part}", text)
        request, response = (self.message(f"srv/{name}_{part}") for part in ("Request", "Response"))
        return SimpleNamespace(Request=request, Response=response, name=name), request, response

    def now(self):
        stamp = self.message(TIMES[self.version - 1])()
        whole, rest = (name for name, _ in stamp.fields)
        nanoseconds = time.time_ns()
        setattr(stamp, whole, nanoseconds // 10**9)
        setattr(stamp, rest, nanoseconds % 10**9)
        return stamp

    def listen(self, topic, kind, heard):
        topic = "/" + topic.lstrip("/")
        self.kinds.setdefault(topic, kind)
        self.heard.setdefault(topic, []).append(heard)

    def publish(self, topic, message):
        topic = "/" + topic.lstrip("/")
        self.kinds.setdefault(topic, type(message))
        assert type(message) is self.kinds[topic], f"{topic} carries {self.kinds[topic].kind}"
        for heard in list(self.heard.get(topic, ())):
            heard(copy.deepcopy(message))

    def end_node(self):
        """End the node's part of the graph, as if its process had died."""
        self.up = False
        time.sleep(0.1)
        self.services.clear()
        for topic in ("/irat/drive", "/irat/odom", "/irat/charger_current"):
            self.heard[topic] = [h for h in self.heard.get(topic, ()) if getattr(h, "__name__", "") == "bridged"]
        self.up = True


def periodically(ros, seconds, work):
    def run():
        while ros.up:
            work()
            time.sleep(seconds)

    threading.Thread(target=run, daemon=True).start()


class Ordered:
    """A mutually exclusive group of callbacks: one after another, in the order in which they came."""


def rclpy_modules(ros):
    class Node:
        def __init__(self, name):
            self.context = SimpleNamespace(ok=lambda: ros.up)

        def declare_parameter(self, name, default):
            return SimpleNamespace(value=default)

        def create_publisher(self, kind, topic, quality):
            return SimpleNamespace(publish=lambda message: ros.publish(topic, message))

        def create_subscription(self, kind, topic, heard, quality, callback_group=None):
            ros.listen(topic, kind, heard)
            ros.groups[topic] = callback_group

        def create_service(self, kind, name, answer, callback_group=None):
            ros.services["/" + name] = kind.Request, lambda request: answer(request, kind.Response())

        def create_timer(self, seconds, work, callback_group=None):
            periodically(ros, seconds, work)

        def get_clock(self):
            return SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=time.time_ns()))

        def get_logger(self):
            return SimpleNamespace(warning=lambda said, throttle_duration_sec: ros.complaints.append(said))

    class Executor:
        def __init__(self, num_threads):
            pass

        def add_node(self, node):
            pass

        def spin(self):
            pass

    return {
        "rclpy": {"init": lambda: None},
        "rclpy.callback_groups": {"ReentrantCallbackGroup": object, "MutuallyExclusiveCallbackGroup": Ordered},
        "rclpy.executors": {"MultiThreadedExecutor": Executor, "ExternalShutdownException": KeyboardInterrupt},
        "rclpy.node": {"Node": Node},
        "rclpy.qos": {"qos_profile_sensor_data": 5},
    }


def rospy_modules(ros):
    def publisher(topic, kind, queue_size):
        return SimpleNamespace(publish=lambda message: ros.publish(topic, message))

    def service(name, kind, answer):
        ros.services["/" + name] = kind.Request, answer

    return {
        "rospy": {
            "init_node": lambda name: None, "get_param": lambda name, default: default, "Publisher": publisher,
            "Subscriber": lambda topic, kind, heard, queue_size: ros.listen(topic, kind, heard), "Service": service,
            "is_shutdown": lambda: not ros.up, "get_time": time.time,
            "logwarn_throttle": lambda seconds, said: ros.complaints.append(said),
        }
    }  # fmt: skip


def types(ros):
    """Return the modules of messages and services, as their packages are generated."""
    found = {}
    for kind in ("geometry_msgs/Twist", "nav_msgs/Odometry", "std_msgs/Float32", "irat/Drive", "irat/State"):
        package, name = kind.split("/")
        found.setdefault(f"{package}.msg", {})[name] = ros.message(kind)
    for package, name in (("std_srvs", "Trigger"), ("irat", "Claim"), ("irat", "Status")):
        made, _, response = ros.service(name)
        found.setdefault(f"{package}.srv", {}).update({name: made, f"{name}Response": response})
    return found


@contextlib.contextmanager
def modules(ros):
    """Make ROS importable meanwhile."""
    wanted = {**(rospy_modules if ros.version == 1 else rclpy_modules)(ros), **types(ros)}
    before = dict(sys.modules)
    sys.path.insert(0, str(SCRIPTS))
    try:
        for name, inside in wanted.items():
            for whole in (name.split(".")[0], name):
                sys.modules.setdefault(whole, ModuleType(whole))
            sys.modules[name].__dict__.update(inside)
        yield
    finally:
        sys.path.remove(str(SCRIPTS))
        for name in set(sys.modules) - set(before):
            del sys.modules[name]


def start_node(ros):
    """Run the node's own file, as its command does."""
    source = SCRIPTS / f"node_ros{ros.version}.py"
    with modules(ros):
        space = {"__name__": "__main__", "__file__": str(source)}
        code = compile(source.read_text(), str(source), "exec")
        if ros.version == 2:
            exec(code, space)
        else:  # it spins in the main thread
            ready = threading.Event()
            space["__name__"] = "node"
            exec(code, space)
            node = space["IratNode"]()
            threading.Thread(target=node.run, daemon=True).start()
            ready.set()
