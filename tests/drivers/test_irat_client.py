"""Our client of rosbridge, and roslibpy as the judge of the simulator's: the real WebSocket between both."""

import builtins
import json
import threading

import pytest
from websockets.sync.server import serve

from robots.kit.contract.errors import ControllerRefused, LineBusy, LineGone, LineSilent, Stopped
from robots.kit.drivers.irat.line import IratLine
from robots.kit.drivers.irat.protocol import Velocity
from robots.kit.drivers.rosbridge_client import Bridge
from tests.conftest import wait_for
from tests.drivers.irat_wire import CLOCK, EPOCHS, WireClient, journal

pytestmark = pytest.mark.timed


@pytest.fixture
def line(irat):
    made = IratLine(str(irat.folder / "tty"), next(EPOCHS), clock=CLOCK)
    made.open()
    yield made
    made.close()


def beats(line, number):
    """Let so many messages of the odometry come, which are as frequent as pictures."""
    for _ in range(number):
        line.odometry.wait(10, after=line.odometry.at)


def test_an_owner_hears_drives_and_holds(irat, line):
    assert line.odometry.wait(3).x == pytest.approx(0, abs=1e-3)
    assert line.battery.wait(3).share == pytest.approx(0.9, abs=0.01)
    assert line.ranges.wait(3).left < 0.4
    assert line.charger.wait(3) == 0

    def far():
        line.drive(Velocity(0.1, 0.0))
        return line.odometry.value.x > 0.04

    wait_for(far, 20, "four centimetres")
    line.hold()
    status = line.ask()
    assert status.motion >= 1
    assert status.moving is False
    assert status.end in ("held", "silence"), "the latter on a machine that stalls"
    assert status.epoch == irat.status()["epoch"]
    assert line.status.wait(2, after=CLOCK.monotonic()).moving is False
    assert line.odometry.wait(2, after=CLOCK.monotonic()).x > 0.03
    assert line.silent_s < 1


def test_pictures_only_while_they_are_watched(irat, line):
    seen = []
    line.watch(seen.append)
    wait_for(lambda: len(seen) > 3, 10, "pictures")
    assert seen[0].jpeg.startswith(b"\xff\xd8")
    assert seen[1].at > seen[0].at
    line.unwatch()
    line.ask()
    beats(line, 3)  # one that was on its way has come
    count = len(seen)
    beats(line, 6)
    assert len(seen) == count


def test_a_permit_that_says_no_sends_nothing(irat, line):
    def stopped():
        raise Stopped("A stop is latched.")

    with pytest.raises(Stopped):
        line.drive(Velocity(0.1, 0.0), stopped)
    line.ask()
    assert irat.count("motion") == 0


def test_a_hold_from_another_thread_while_a_call_waits(irat, line):
    line.drive(Velocity(0.1, 0.0))
    threads = [threading.Thread(target=line.hold) for _ in range(5)]
    for thread in threads:
        thread.start()
    assert line.ask()
    for thread in threads:
        thread.join(5)
    assert irat.count("hold") == 5
    assert not line.ask().moving


def test_an_owner_whose_robot_obeys_another_is_told(irat, line):
    line.status.wait(3, after=CLOCK.monotonic())
    line.obeys()
    newer = WireClient(irat).claim()["epoch"]
    wait_for(lambda: line.status.value.epoch == newer, 5, "the robot's word of it")
    with pytest.raises(LineBusy, match="another client: epoch"):
        line.obeys()


def test_another_owner_is_told_who_commands(irat, line):
    stale = IratLine(irat.address, 1)
    with pytest.raises(LineBusy, match="is over"):
        stale.open()
    assert not stale.bridge.is_open


def test_a_lost_connection_is_an_error_at_once_and_opens_again(irat, line):
    irat.fault("restart", count=1)
    wait_for(lambda: not line.bridge.is_open, 5, "the end of the connection")
    for ask in (line.ask, line.hold, lambda: line.drive(Velocity(0.1, 0.0)), lambda: line.silent_s):
        with pytest.raises(LineGone):
            ask()
    before = line.odometry.at
    line.open()
    assert line.odometry.wait(3, after=before)
    line.drive(Velocity(0.05, 0.0))
    wait_for(lambda: irat.count("motion"), 3, "the motion")


def test_a_silent_robot_is_an_error_and_a_late_answer_belongs_to_nobody(irat, line):
    irat.fault("slow", 1.5)
    with pytest.raises(LineSilent):
        line.ask()
    irat.clear()
    beats(line, 3)  # the late answer came before the last of them
    assert line.ask().moving is False


def test_nobody_listens(tmp_path):
    with pytest.raises(LineGone):
        Bridge("ws://127.0.0.1:9").open()
    with pytest.raises(LineGone):
        Bridge(str(tmp_path / "nothing")).open()
    with pytest.raises(LineGone):
        Bridge("127.0.0.1:9").call("/irat/status")


HUGE = tuple("9" * digits for digits in (309, 400, 4300, 5000))
NONSENSE = (
    "", "{", "[]", "7", b"\x00\xff", '{"op": "publish"}', '{"op": "publish", "topic": "/irat/odom", "msg": 3}',
    '{"op": "publish", "topic": "/irat/odom", "msg": {"pose": {"pose": {"position": {"x": "far"}}}}}',
    '{"op": "publish", "topic": "/irat/odom", "msg": {"pose": {"pose": {"position": {"x": 1e300}}}}}',
    '{"op": "publish", "topic": "/irat/ranges", "msg": {"ranges": [1, 2]}}',
    '{"op": "publish", "topic": "/irat/ranges", "msg": {"ranges": [null, {}, "x"]}}',
    '{"op": "publish", "topic": "/irat/camera/image/compressed", "msg": {"format": "jpeg", "data": "####"}}',
    '{"op": "publish", "topic": "/irat/camera/image/compressed", "msg": {"format": "jpeg", "data": "aGVsbG8="}}',
    '{"op": "service_response", "id": {"x": 1}, "values": 1}', '{"op": "service_response", "id": "call:99999"}',
    '{"op": "status", "msg": {"a": []}}', '{"op": "png", "data": "x"}',
    *(frame.replace("HUGE", digits) for digits in HUGE for frame in (
        '{"op": "publish", "topic": "/irat/odom", "msg": {"pose": {"pose": {"position": {"x": HUGE}}}}}',
        '{"op": "publish", "topic": "/irat/odom", "msg": {"header": {"stamp": {"sec": HUGE}}}}',
        '{"op": "publish", "topic": "/irat/ranges", "msg": {"ranges": [-HUGE, 1, 1], "range_max": HUGE}}',
        '{"op": "publish", "topic": "/irat/battery", "msg": {"voltage": 7, "percentage": HUGE}}',
        '{"op": "publish", "topic": "/irat/state", "msg": {"boot": 1, "epoch": HUGE}}',
        '{"op": "service_response", "id": HUGE}',
    )),
)  # fmt: skip


def test_a_robot_that_talks_nonsense_ends_nothing():
    """Each frame is dropped; the connection, its thread and the newest good values stay."""

    def talk(connection):
        for data in connection:
            asked = json.loads(data)
            if asked["op"] == "call_service":
                for frame in NONSENSE:
                    connection.send(frame)
                epoch = asked["args"].get("epoch", 0)
                values = {"success": True, "message": "", "epoch": epoch} if epoch else "no"
                connection.send(
                    json.dumps({"op": "service_response", "id": asked["id"], "values": values, "result": True})
                )

    with serve(talk, "127.0.0.1", 0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        line = IratLine(f"127.0.0.1:{server.socket.getsockname()[1]}", 5, lambda picture: pytest.fail("no picture"))
        line.open()
        with pytest.raises(ControllerRefused):
            line.ask()
        with pytest.raises(LineSilent):
            line.odometry.wait(0.1)
        assert line.bridge.is_open
        assert line.bridge.unreadable >= 2 * (9 + 4 * len(HUGE))
        line.close()


RAISED = sorted(
    (e for e in vars(builtins).values() if isinstance(e, type) and issubclass(e, Exception)),
    key=lambda error: error.__name__,
)


def test_whatever_a_listener_raises_the_next_message_is_heard():
    heard = []

    def listen(message):
        heard.append(message["data"])
        error = RAISED[message["data"]]
        if issubclass(error, UnicodeError) and error is not UnicodeError:
            raise UnicodeError
        raise error("") if not issubclass(error, BaseExceptionGroup) else error("", [ValueError()])

    def talk(connection):
        connection.recv()
        for number in range(len(RAISED)):
            connection.send(json.dumps({"op": "publish", "topic": "/a", "msg": {"data": number}}))
        connection.recv()

    with serve(talk, "127.0.0.1", 0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        bridge = Bridge(f"127.0.0.1:{server.socket.getsockname()[1]}")
        bridge.open()
        bridge.subscribe("/a", "std_msgs/Int32", listen)
        wait_for(lambda: len(heard) == len(RAISED), 10, "each message")
        assert bridge.is_open and bridge.unreadable == len(RAISED)
        bridge.close()


@pytest.fixture
def ros(irat):
    import roslibpy

    host, port = irat.address.removeprefix("ws://").split(":")
    made = roslibpy.Ros(host, int(port), transport="asyncio")
    made.run(timeout=20)
    yield made
    made.close()
    wait_for(lambda: made.factory._proto is None, 20, "the end of its connection, which its loop has seen")
    made.terminate()


def test_roslibpy_speaks_with_the_simulator(irat, ros):
    """Topics, services and the camera, by a client that is not ours."""
    import roslibpy

    assert "/irat/odom" in ros.get_topics()
    claim = roslibpy.Service(ros, "/irat/claim", "irat/Claim")
    assert claim.call(roslibpy.ServiceRequest({"epoch": next(EPOCHS)}), timeout=5)["success"]
    heard, pictures = [], []
    odometry = roslibpy.Topic(ros, "/irat/odom", "nav_msgs/Odometry")
    odometry.subscribe(heard.append)
    camera = roslibpy.Topic(ros, "/irat/camera/image/compressed", "sensor_msgs/CompressedImage")
    camera.subscribe(pictures.append)
    command = roslibpy.Topic(ros, "/irat/cmd_vel", "geometry_msgs/Twist")
    command.advertise()
    ahead = {"linear": {"x": 0.1, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}

    def far():
        command.publish(roslibpy.Message(ahead))
        return heard and heard[-1]["pose"]["pose"]["position"]["x"] > 0.04

    wait_for(far, 20, "four centimetres")
    hold = roslibpy.Service(ros, "/irat/hold", "std_srvs/Trigger").call(roslibpy.ServiceRequest({}), timeout=5)
    assert hold["success"]
    assert journal(irat, "rest")[-1]["end"] in ("held", "silence"), "the latter on a machine that stalls"
    wait_for(lambda: len(pictures) > 3, 10, "pictures")
    assert pictures[0]["format"] == "jpeg"
    assert heard[-1]["pose"]["pose"]["position"]["x"] > 0.03
    with pytest.raises(Exception, match="no service"):
        roslibpy.Service(ros, "/irat/dance", "x/Y").call(roslibpy.ServiceRequest({}), timeout=5)
    for topic in (odometry, camera):
        topic.unsubscribe()
    command.unadvertise()


def test_our_client_and_roslibpy_read_the_same(irat, line, ros):
    import roslibpy

    heard = []
    topic = roslibpy.Topic(ros, "/irat/ranges", "sensor_msgs/LaserScan")
    topic.subscribe(heard.append)
    wait_for(lambda: heard, 5, "their ranges")
    ours = line.ranges.wait(3)
    right, ahead, left = heard[-1]["ranges"]
    assert (left, ahead, right) == pytest.approx((ours.left, ours.ahead, ours.right), abs=0.03)
    topic.unsubscribe()


def test_the_hand_and_the_line_are_one_protocol(irat, line):
    """A stranger by hand is told the same as the owner's client decodes."""
    by_hand = WireClient(irat).status()
    ours = line.ask()
    assert {**ours.encode(), "seconds": 0} == {**by_hand, "seconds": 0}
