"""The rover's Wi-Fi module: one client, faults, the slow radio; and a console that others wrote."""

import contextlib
import socket
from functools import partial

import pytest

from robots.kit.clock import FasterTimer, poll
from robots.kit.drivers.srv1.extension import HOLD
from robots.kit.drivers.srv1.protocol import RESYNCHRONISE, motion
from robots.kit.drivers.stream import host_and_port, open_stream
from simulators.common.faults import FaultBoard
from simulators.common.tcp import TcpListener
from simulators.srv1.firmware import Firmware
from simulators.srv1.imaging import jpeg
from simulators.srv1.link import Link
from simulators.srv1.media import Internet, Radio
from simulators.srv1.network import Network
from tests.drivers.srv1_wire import BOOT, JPEG, SEEN, TICK_S, Bench, Rig
from tests.world.streams import Door
from tests.world.streams import Network as Between
from tests.world.world import World

pytestmark = pytest.mark.django_db(transaction=True)


class Wire:
    """A client's connection, on which silence is no bytes."""

    def __init__(self, address, opened=open_stream):
        self._stream = opened(*host_and_port(address), 2.0)
        self.write, self.close = self._stream.sendall, self._stream.close

    def read(self, most, seconds):
        try:
            data = self._stream.receive(most, seconds)
        except TimeoutError:
            return b""
        if not data:
            raise ConnectionError("the rover's Wi-Fi module has closed the connection")
        return data


class LinkRig(Rig):
    """The firmware behind its Wi-Fi module, or a radio, and what connects in memory."""

    def __init__(self, radio_m: float | None = None) -> None:
        super().__init__()
        radio = None if radio_m is None else Radio(lambda: radio_m)
        self.link = Link(self.firmware.receive, self.bench.faults, self.bench.drive._note, self.world, radio)
        self.between = Between(self.world)
        self.network = Network(self.link, self.bench.drive._note, self.world)
        self.network.listen(Door(self.between))
        self.world.spawn(self.link.run, "link")

    def hear(self, data: bytes) -> float:
        return self.link.say(data) if hasattr(self, "link") else 0.0

    def connect(self) -> Wire:
        return Wire("127.0.0.1:10001", self.between.connect)


@pytest.fixture
def opened():
    made = []

    def begin(*args):
        made.append(LinkRig(*args))
        return made[-1]

    yield begin
    for rig in made:
        rig.close()


def ask(wire, data, seconds=0.3):
    wire.write(data)
    heard = b""
    while piece := wire.read(4096, seconds):
        heard += piece
    return heard


def test_one_client_at_a_time(opened):
    rig = opened()
    one = rig.connect()
    assert ask(one, b"V").startswith(b"##Version")
    other = rig.connect()
    with pytest.raises(ConnectionError):
        other.read(10, 1.0)
    assert rig.count("refused") == 1
    assert ask(one, b"D").startswith(b"##D"), "the first stays"
    one.close()
    rig.pass_s(0.1)
    assert ask(rig.connect(), b"V").startswith(b"##Version")


def test_the_end_of_a_connection_ends_no_command(opened):
    rig = opened()
    one = rig.connect()
    one.write(b"M\x3c")
    rig.pass_s(0.1)
    one.close()
    rig.pass_s(0.1)
    assert ask(rig.connect(), b"\x3c\x0a") == b"#M", "the next client's bytes are its arguments"
    assert rig.bench.drive.motion == 1


def test_power_off_ends_the_connection_and_the_next_client_may_hear_it_start(opened):
    rig = opened()
    one = rig.connect()
    rig.pass_s(0.1)
    rig.link.power_off()
    rig.firmware.restart()
    with pytest.raises(ConnectionError):
        one.read(10, 1.0)
    assert ask(rig.connect(), b"", 1.5) == BOOT


@pytest.mark.parametrize("hold", [HOLD, b"5"])
def test_a_hold_that_is_lost_on_its_way(opened, hold):
    rig = opened()
    wire = rig.connect()
    wire.write(b"M\x3c\x3c\x00")
    rig.pass_s(1.0)
    rig.bench.faults.set("flushed_hold", count=1)
    assert ask(wire, hold) == b"#M"
    assert rig.bench.drive.moving
    assert ask(wire, hold)
    assert rig.rest() in ("held", "done")


def test_faults_of_the_line(opened):
    rig = opened()
    wire, faults = rig.connect(), rig.bench.faults
    for verb in ("awol", "mute"):
        faults.set(verb)
        assert ask(wire, b"V") == b""
        faults.clear()
    faults.set("slow", 0.5)
    assert ask(wire, b"V", 0.9) == b""
    assert wire.read(100, 0.2).startswith(b"##Version"), "half a second there, half a second back"
    faults.clear()
    faults.set("corrupt", 1.0)
    assert not ask(wire, b"V").startswith(b"##Version")
    faults.clear()
    ask(wire, RESYNCHRONISE)  # it may have become a letter that waits for more
    faults.set("drop", 1.0)
    assert ask(wire, b"V") == b""
    faults.clear()
    faults.set("cut", count=1)
    with pytest.raises(OSError):
        ask(wire, b"V")
    assert ask(rig.connect(), b"V").startswith(b"##Version")


def test_the_radio_is_slow_and_of_a_short_reach(opened):
    rig = opened(10.0)
    wire, bits = rig.connect(), 8 * len(b"#f")
    began = rig.world.monotonic()
    wire.write(b"f")
    assert wire.read(10, 1.0) == b"#f"
    assert rig.world.monotonic() - began == pytest.approx(0.037 + (bits + 8) / 7000, abs=0.005)
    rig.bench.seen = SEEN[::4, ::4]
    began = rig.world.monotonic()
    bits = 8 * (10 + len(jpeg(rig.bench.seen)))
    assert len(ask(wire, b"I", 3.0)) == bits // 8
    assert rig.world.monotonic() - began - 3.0 == pytest.approx(bits / 7000, abs=0.1)
    rig.bench.faults.set("far", 20.5)
    assert ask(wire, b"V") == b""
    rig.bench.faults.set("far", 20.0)
    assert ask(wire, b"V").startswith(b"##Version")


class Far:
    """A link alone in a world: what each end says, with when it was said and when it came."""

    name = "the test"

    def __init__(self, seed):
        self.world, self.came = World(5), {True: [], False: []}
        self.link = Link(
            partial(self._come, True), FaultBoard(), lambda *told, **more: None, self.world, Internet(seed)
        )  # fmt: skip
        assert self.link.join(self)
        self.world.spawn(self.link.run, "link")

    def _come(self, to_robot, data):
        self.came[to_robot].append((self.world.monotonic(), data))

    def say(self, data):
        self._come(False, data)

    def cut(self):
        raise AssertionError("nobody cuts it")

    def delays(self, pieces=200):
        """Say pieces from both ends; return by direction how long each took (s)."""
        said = {True: [], False: []}
        for number in range(pieces):
            data = b"%d" % number
            for to_robot in (True, False):
                said[to_robot].append((self.world.monotonic(), data))
            self.link.take(self, data)
            self.link.say(data)
            self.world.sleep(0.013)
        self.world.sleep(1.0)
        self.world.close()
        for way in (True, False):
            assert [data for _, data in self.came[way]] == [data for _, data in said[way]], "in order, and all"
        return {way: [b - a for (a, _), (b, _) in zip(said[way], self.came[way], strict=True)] for way in said}


def test_the_internet_takes_its_time_each_way_by_the_seed_and_keeps_the_order():
    one, again, other = (Far(seed).delays() for seed in (1, 1, 2))
    for way in (True, False):
        assert min(one[way]) >= 0.07
        assert max(one[way]) <= 0.1201
        assert max(one[way]) - min(one[way]) > 0.03, "it is not the same each time"
    assert one == again
    assert one != other


def test_a_hold_is_heard_while_a_picture_goes_over_the_radio(opened):
    rig = opened(10.0)
    wire = rig.connect()
    rig.bench.seen = SEEN[::2, ::2]  # so that it goes for 2 s
    assert 1500 < len(jpeg(rig.bench.seen)) < 2000
    wire.write(b"M\x3c\x3c\x00")
    rig.pass_s(1.0)
    wire.write(b"I")
    rig.pass_s(1.0)
    wire.write(HOLD)
    assert rig.rest() == "held"


class Console:
    """What the console of Mac (SRV1Console for Android, 2009) does with its socket, request by request."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=30)

    def clear(self) -> None:
        """Do `clearInputStream`."""
        self.socket.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            while self.socket.recv(4096):
                pass
        self.socket.settimeout(30)

    def read(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            piece = self.socket.recv(count - len(data))
            assert piece, "the connection ended"
            data += piece
        return data

    def motors(self, left: int, right: int, duration: int) -> bool:
        self.clear()
        for byte in (ord("M"), left & 255, right & 255, duration):  # one `writeByte` each
            self.socket.sendall(bytes((byte,)))
        return self.read(2) == b"#M"

    def letter(self, letter: bytes) -> bool:
        self.clear()
        self.socket.sendall(letter)
        return self.read(2) == b"#" + letter

    def servos(self, left: int, right: int) -> bool:
        self.clear()
        self.socket.sendall(bytes((ord("S"), left, right)))
        return self.read(2) == b"#S"

    def picture(self) -> bytes:
        """Do `SRV1VideoCommand`: as soon as the header's six bytes are there, the size must be there, too."""
        self.clear()
        self.socket.sendall(b"I")
        while len(there := self.socket.recv(64, socket.MSG_PEEK)) < 6:
            pass
        assert len(there) >= 10
        assert self.read(6) == b"##IMJ5"
        return self.read(int.from_bytes(self.read(4), "little"))

    def close(self) -> None:
        self.socket.close()


@pytest.fixture
def port():
    """Give the port of a rover that lives in real threads, 20 times as fast."""
    clock, notes = FasterTimer(20), []
    bench = Bench(lambda event, **more: notes.append((event, more)))
    lock = clock.lock()
    firmware = Firmware(bench, lambda data: link.say(data), bench.drive._note, clock, lock, stock=True)
    link = Link(firmware.receive, bench.faults, bench.drive._note, clock)
    network, listener, lives = Network(link, bench.drive._note, clock), TcpListener(0), [True]

    def floor():
        while lives:
            clock.sleep(TICK_S)
            with lock:
                bench.step()
            firmware.tick(bench.now)

    threads = [
        clock.spawn(run, name) for run, name in ((firmware.run, "firmware"), (link.run, "link"), (floor, "floor"))
    ]
    network.listen(listener)
    assert poll(lambda: firmware.started, clock, 600.0, 0.1)
    yield listener.port
    lives.clear()
    firmware.stop()
    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", listener.port)):
        network.close()
    for thread in threads:
        thread.join(5)
        assert not thread.is_alive()


def test_a_console_that_others_wrote_is_served(port):
    with contextlib.closing(Console(port)) as console:
        assert console.letter(b"b")
        assert console.picture() == JPEG
        assert console.motors(40, -40, 20)
        assert console.motors(0, 0, 0)
        assert console.letter(b"l")
        assert console.letter(b"L")
        assert console.servos(50, 50)
        assert console.picture() == JPEG


def test_a_second_client_is_closed_at_once_over_tcp(port):
    with contextlib.closing(Console(port)) as console:
        assert console.letter(b"l")
        with contextlib.closing(Console(port)) as other, contextlib.suppress(ConnectionError):
            assert other.socket.recv(10) == b""
        assert console.letter(b"L")


def test_half_a_motion_over_tcp_waits_for_the_rest(port):
    with contextlib.closing(Wire(f"socket://127.0.0.1:{port}")) as wire:
        wire.write(motion(20, 20, 0.01)[:2])
        assert wire.read(10, 0.01) == b""
        wire.write(motion(20, 20, 0.01)[2:])
        assert wire.read(1, 30.0) + wire.read(1, 30.0) == b"#M"
