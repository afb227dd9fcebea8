"""Sound of a robot's microphone: nothing is opened that nobody hears, what is heard is what the arm does, and a
microphone that dies takes nothing with it."""

import json
import time
from urllib.parse import quote

import av
import numpy as np
import pytest

from robots import bus
from robots.kit.contract.sound import RATE, unpack
from robots.models import Incident, Robot
from robots.states import CommandState
from tests.conftest import wait_for
from tests.faults.here import heard, line
from tests.faults.test_viewers import Viewer

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

SOUND, VIDEO = 5, 4
WISH = {"t": "watch", "cameras": [0], "every_s": 0, "compact": False, "video": "vp9"}
ASKED = WISH | {"sound": True}
PATH = f"/ws/robots/mercury/?watch={quote(json.dumps(ASKED))}"


def give_a_microphone(rig):
    Robot.objects.filter(pk=rig.robot.pk).update(microphone="sim:microphone")


@pytest.fixture
def listened(rig):
    """A robot with a microphone, and its owner."""
    give_a_microphone(rig)
    rig.owner()
    rig.robot.refresh_from_db()
    time.sleep(1.2)  # its owner reads the row again
    return rig


class Listener:
    """One who listens: the packets of sound and how many of video came over a socket."""

    def __init__(self, one):
        self._one, self.packets, self.filmed = one, [], 0

    def during(self, seconds):
        """Return the packets of the next seconds."""
        first, until = len(self.packets), time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0:
            try:
                data = self._one.recv(timeout=left)
            except TimeoutError:
                break
            if isinstance(data, bytes) and data[0] == SOUND:
                self.packets.append(unpack(data))
            self.filmed += isinstance(data, bytes) and data[0] == VIDEO
        return self.packets[first:]

    def until(self, condition, seconds, what):
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, f"{what}: not within {seconds} s"
            self.during(0.1)

    def sounds(self):
        return [packet for packet in self.packets if packet.ms]


def levels(packets):
    """Return the level of each packet that an independent decoder finds (dB below full scale)."""
    decoder = av.CodecContext.create("opus", "r")
    decoder.sample_rate, decoder.layout = RATE, "mono"
    found = []
    for packet in packets:
        frames = decoder.decode(av.Packet(packet.data))
        samples = np.concatenate([frame.to_ndarray().ravel() for frame in frames]).astype(float)
        assert samples.size == RATE * packet.ms // 1000
        assert {frame.sample_rate for frame in frames} == {RATE}
        found.append(10 * np.log10(np.mean(samples**2) + 1e-12))
    return found


@pytest.mark.asvs("14.2.4")
def test_nobody_listens_then_one_does_and_hears_the_arm_move(listened, web):
    rig = listened
    before = rig.sim.status()["listened"]
    plain_path = f"/ws/robots/mercury/?watch={quote(json.dumps(WISH))}"
    with line(web, path=plain_path) as plain:
        watcher = Listener(plain)
        watcher.until(lambda: watcher.filmed > 3, 30, "pictures")
        status = rig.sim.status()
        assert (status["listened"], status["listeners"]) == (before, 0), "nobody listens"
        with line(web, path=PATH) as one:
            listener = Listener(one)
            listener.until(lambda: len(listener.sounds()) > 25, 20, "sound")
            quiet = len(listener.sounds())
            rig.grant()
            moved = rig.issue("move", x=0.15, y=0.52)
            listener.until(lambda: moved.__class__.objects.get(pk=moved.pk).final, 30, "the motion")
            status = rig.sim.status()
            assert status["listeners"] == 1 <= status["listened"] - before
            sounds = listener.sounds()
            numbers, level = [p.number for p in sounds], levels(sounds)
            assert numbers == sorted(set(numbers))
            assert abs(sounds[-1].at_ms / 1000 - time.time()) < 3, "stamped with the present"
            assert max(level[3:quiet]) < -40 < max(level[quiet:]), "it is heard that the arm moves"
            assert max(level[quiet:]) > max(level[3:quiet]) + 12
            assert sum(len(p.data) for p in sounds) * 8 / (len(sounds) * 0.06) < 40_000, "bits a second"
            one.send(json.dumps(WISH))
            listener.until(lambda: rig.sim.status()["listeners"] == 0, 15, "a microphone that nobody hears is left")
            before = len(listener.packets)
            assert len(listener.during(1.0)) == 0
        watcher.during(0.3)
        assert watcher.packets == [], "who did not ask is given nothing"
    web.nothing_left()


def test_a_microphone_that_dies_takes_nothing_with_it_and_is_heard_again(rig, web):
    give_a_microphone(rig)
    rig.start_worker()  # an owner tells staff once an hour
    rig.wait_ready()
    with line(web, path=PATH) as one:
        listener = Listener(one)
        listener.until(lambda: len(listener.sounds()) > 5, 20, "sound")
        run = listener.sounds()[-1].run
        rig.sim.fault("mic_gone")
        listener.until(lambda: listener.packets[-1].text, 15, "a sentence")
        assert "microphone" in listener.packets[-1].text
        filmed = listener.filmed
        rig.grant()
        command = rig.issue("move", x=-0.1, y=0.45)
        assert rig.final(command).state == CommandState.COMPLETED
        listener.until(lambda: listener.filmed > filmed + 5, 20, "pictures go on")
        assert Incident.objects.filter(code="microphone").count() == 1, "staff are told once"
        rig.sim.clear()
        listener.until(lambda: listener.packets[-1].ms, 25, "sound again")
        assert listener.packets[-1].run != run
        rig.sim.fault("mic_mute")  # connected, but nothing comes
        listener.until(lambda: listener.packets[-1].text, 15, "a sentence")
        Robot.objects.filter(pk=rig.robot.pk).update(microphone="")
        wait_for(lambda: rig.sim.status()["listeners"] == 0, 10, "no microphone any more")
        rig.swept()  # the owner has read that it has no address
        listener.during(2.5)
        assert listener.during(1.2) == [], "without an address nothing is told"


def test_what_comes_over_the_bus_goes_to_those_who_listen_alone(web):
    with line(web, path=PATH) as one, line(web) as plain:
        heard(one, "snapshot")
        heard(plain, "snapshot")
        assert bus.watched("mercury", bus.SOUND)
        for n in range(20):
            bus.publish_sound("mercury", bytes([SOUND]) + b"x" * 40 + bytes([n]))
        found = []
        while len(found) < 20:
            data = one.recv(timeout=5)
            found += [data[-1]] if isinstance(data, bytes) else []
        assert found == list(range(20))
        bus.publish_picture("mercury", b"\x02" + bytes(50))
        while not isinstance(data := plain.recv(timeout=5), bytes):
            pass
        assert data[0] == 2
    web.nothing_left()


def test_one_who_does_not_read_has_no_backlog(web):
    slow = Viewer(web, query=f"?watch={quote(json.dumps(ASKED))}")
    wait_for(lambda: bus.watched("mercury", bus.SOUND), 5, "the wish")
    for n in range(300):
        bus.publish_sound("mercury", bytes([SOUND]) + bytes(6000) + n.to_bytes(2, "big"))
        time.sleep(0.005)
        if n % 10 == 0:
            slow.read(12_000)  # a fifth of what is sent
    slow.until_quiet()
    numbers = [int.from_bytes(data[-2:], "big") for data in slow.binary() if data[0] == SOUND]
    assert numbers == sorted(set(numbers))
    assert 20 < len(numbers) < 200
    assert numbers[-1] == 299, "the newest are kept"
    slow.close()
    web.nothing_left()
