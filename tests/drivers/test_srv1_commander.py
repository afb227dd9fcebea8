"""Our extension of the rover's firmware: claim, velocities, hold at any moment, patrol, permit, rules, journal."""

from binascii import crc_hqx

import pytest

from robots.kit.description import text_of
from robots.kit.drivers.srv1 import answers, protocol
from robots.kit.drivers.srv1.answers import Acknowledgement, Event, Reason, Refusal, Status
from robots.kit.drivers.srv1.extension import HOLD, Activate, Ask, Claim, Hold, Journal, Patrol, Permit, Velocity
from robots.kit.drivers.srv1.framing import ANSWER, Frames
from robots.kit.rovers.fuzzy import PAPER, sugeno
from robots.kit.rovers.fuzzy_text import parse as parse_text
from simulators.srv1.commander import MADE_WITH
from simulators.srv1.patrol import TURN_RAD_S
from simulators.srv1.patrol import Patrol as Course
from tests.drivers.srv1_wire import JPEG, Rig

pytestmark = pytest.mark.django_db(transaction=True)
HALL = (0.0, 0.0, 12.0, 8.0)


class Constant:
    """A rule set that always says the same speed (mm/s)."""

    inputs = ("infrared", "sonar")

    def __init__(self, speed):
        self.speed = speed

    def speed_mm_s(self, infrared_mm, sonar_mm):
        return self.speed


class Warm(Constant):
    """A rule set that says its speed where temperature and humidity are as on the bench."""

    inputs = ("temperature", "humidity")

    def speed_mm_s(self, temperature, humidity):
        return self.speed * (abs(temperature - 21_000) < 60 and abs(humidity - 40_000) < 60)


def parse(text):
    if text.startswith("warm"):
        return Warm(100)
    if not text.startswith("speed"):
        raise ValueError("this is no rule set")
    return Constant(int(text.split()[1]))


@pytest.fixture
def rig():
    made = Rig(parse=parse)
    yield made
    made.close()


def stamp(rig):
    return rig.ask(Ask()).uptime_ms


def drive(rig, seconds, linear=0.2, angular=0.0, epoch=7):
    """Say a velocity ten times a second."""
    answer = None
    for _ in range(round(seconds / 0.1)):
        answer = rig.ask(Velocity(epoch, linear, angular, stamp(rig)))
    return answer


def patrol(rig, seconds, epoch=7):
    for _ in range(round(seconds / 0.1)):
        rig.ask(Patrol(epoch, stamp(rig)), 0.1)


def permit(rig, seconds, speed=0.2, area=HALL, epoch=7):
    return Permit(epoch, stamp(rig) + round(1000 * seconds), speed, area)


def events(rig):
    found, since = [], 0
    while entries := rig.ask(Journal(since)).entries:
        found += entries
        since = entries[-1].number
    return [entry.event for entry in found]


def test_it_tells_its_state(rig):
    told = rig.ask(Ask())
    assert isinstance(told, Status)
    assert (told.boot, told.epoch, told.moving, told.mode, told.end) == (1, 0, False, "rest", "none")
    assert (told.x, told.y, told.heading) == pytest.approx((1.0, 1.0, 0.0), abs=0.01)
    assert (told.infrared, told.sonar, told.volts) == (0.8, 5.0, 7.9)
    assert told.temperature == pytest.approx(21.0, abs=0.1)
    assert told.humidity == pytest.approx(0.4, abs=0.001)
    assert told.uptime_ms == pytest.approx(1100, abs=60)


def test_velocities_count_under_the_claimed_epoch_alone(rig):
    assert rig.ask(Velocity(7, 0.2, 0.0, stamp(rig))) == Refusal("v", Reason.EPOCH)
    assert rig.ask(Claim(7)).epoch == 7
    assert isinstance(drive(rig, 1.0), Status)
    assert rig.bench.drive.motion == 1
    assert rig.ask(Velocity(8, 0.2, 0.0, stamp(rig))) == Refusal("v", Reason.EPOCH)
    assert rig.ask(Claim(6)) == Refusal("c", Reason.EPOCH)
    drive(rig, 0.2)
    rig.ask(Claim(8))
    assert rig.rest() == "replaced"
    assert rig.ask(Velocity(7, 0.2, 0.0, stamp(rig))) == Refusal("v", Reason.EPOCH)
    rig.pass_s(61.0)
    assert rig.ask(Claim(3)).epoch == 3, "an epoch that nobody uses any more locks nobody out"


@pytest.mark.parametrize("question", [Ask(), Journal(0), Claim(9), Velocity(9, 0.0, 0.0, 0)])
def test_an_owner_that_says_anything_keeps_its_epoch(rig, question):
    rig.ask(Claim(9))
    for _ in range(70):
        rig.ask(question, 1.0)
    assert rig.ask(Claim(3)) == Refusal("c", Reason.EPOCH)
    assert isinstance(rig.ask(Velocity(9, 0.2, 0.0, stamp(rig))), Status)


def test_whoever_is_refused_keeps_no_epoch(rig):
    """So a wrong one locks nobody out for longer than a minute, however often its owner tries."""
    rig.ask(Claim(2**53 - 1))
    answers_ = [rig.ask(Claim(3), 3.0) for _ in range(20)]
    assert answers_ == [Refusal("c", Reason.EPOCH)] * 20
    rig.say(HOLD, 3.0)
    rig.say(b"V", 3.0)
    assert rig.ask(Claim(3)).epoch == 3


def test_a_power_cycle_forgets_the_epoch_and_says_so(rig):
    rig.ask(Claim(9))
    rig.firmware.restart()
    rig.pass_s(1.1)
    told = rig.ask(Ask())
    assert (told.boot, told.epoch) == (2, 0)
    assert rig.ask(Velocity(9, 0.2, 0.0, stamp(rig))) == Refusal("v", Reason.EPOCH), "it has to claim it anew"
    assert rig.ask(Claim(9)).epoch == 9


def test_rules_come_into_force_under_the_claimed_epoch_alone(rig):
    """An earlier owner that is still connected, or an unknown client, may have filled the buffer."""
    text = b"speed 150"
    rig.firmware.flash.load(text)
    crc = crc_hqx(text, 0)
    for epoch in (0, 7):
        assert rig.ask(Activate(epoch, crc)) == Refusal("u", Reason.EPOCH)
    rig.ask(Claim(9))
    for epoch in (0, 7, 10):
        assert rig.ask(Activate(epoch, crc)) == Refusal("u", Reason.EPOCH)
    assert (rig.ask(Ask()).rules, rig.count("rules")) == (0, 0)
    assert isinstance(rig.ask(Activate(9, crc)), Acknowledgement)
    assert rig.ask(Ask()).rules == crc


def test_a_velocity_is_forgotten(rig):
    rig.ask(Claim(7))
    drive(rig, 1.0)
    status = rig.ask(Ask())
    assert status.moving
    assert status.mode == "hand"
    assert status.linear == pytest.approx(0.2, abs=0.03)
    assert rig.rest() == "silence"
    assert rig.ask(Ask()).mode == "rest"


def test_a_velocity_that_answers_to_an_old_status_is_refused(rig):
    rig.ask(Claim(7))
    seen = stamp(rig)
    rig.pass_s(0.6)
    assert rig.ask(Velocity(7, 0.2, 0.0, seen)) == Refusal("v", Reason.LATE)
    assert rig.ask(Velocity(7, 0.2, 0.0, stamp(rig) + 5000)) == Refusal("v", Reason.LATE)
    assert rig.ask(Velocity(7, 1.0, 0.0, stamp(rig))) == Refusal("v", Reason.BOUNDS)
    assert not rig.count("motion")


@pytest.mark.parametrize(
    "before",
    [b"M\x3c\x3c\x00", b"M\x3c\x3c\xff", b"M", b"M\x3c", b"8", b"I", b"X", b"%v7,2", b"z", b"\x00" * 4000, b"F\x3c"],
)
def test_a_hold_is_heard_whatever_it_stands_in(rig, before):
    rig.say(b"M\x3c\x3c\x00", 1.0)
    assert rig.bench.drive.moving
    rig.firmware.receive(before)
    rig.pass_s(0.01)
    heard = rig.say(HOLD)
    status = answers.decode(Frames(ANSWER).feed(heard)[0])
    assert status.letter == "h"
    assert status.holding
    assert rig.rest() == "held"
    assert rig.say(b"V").startswith(b"##Version"), "and the loop is free"
    assert rig.ask(Ask()).end == "held"


def test_a_hold_is_heard_in_pieces_and_a_picture_is_whole(rig):
    rig.say(b"M\x3c\x3c\x00", 1.0)
    for piece in (b"I" + HOLD[:1], HOLD[1:4], HOLD[4:] + b"V"):
        rig.firmware.receive(piece)
    rig.heard.clear()
    rig.pass_s(0.1)
    assert rig.rest() == "held"
    rig.heard.clear()
    rig.firmware.receive(b"I")
    rig.pass_s(0.005)
    rig.firmware.receive(HOLD)
    rig.pass_s(0.1)
    assert JPEG in rig.heard
    assert Frames(ANSWER).feed(bytes(rig.heard))[0].letter == "h"


def test_while_it_is_held_nothing_drives_it(rig):
    rig.ask(Claim(7))
    drive(rig, 1.0, 0.4)
    rig.say(HOLD, 0.02)
    assert rig.ask(Velocity(7, 0.2, 0.0, rig.firmware.commander.uptime_ms), 0.02) == Refusal("v", Reason.HOLDING)
    assert rig.ask(Patrol(7, stamp(rig)), 0.02) == Refusal("g", Reason.HOLDING)
    rig.say(b"M\x3c\x3c\x00", 0.02)
    assert rig.rest() == "held"
    assert rig.count("motion") == 1


def test_it_patrols_while_it_is_told_to_and_no_longer(rig):
    rig.ask(Claim(7))
    patrol(rig, 2.0)
    status = rig.ask(Ask())
    assert status.mode == "patrol"
    assert status.linear == pytest.approx(sugeno(PAPER, rig.bench.infrared(), rig.bench.sonar()), abs=0.01)
    assert rig.rest() == "silence"
    assert rig.ask(Ask()).mode == "rest"


def test_the_reflex_is_below_all_rules(rig):
    rig.say(b"X", 0.0)
    activate(rig, b"speed 400")
    rig.ask(Claim(7))
    patrol(rig, 2.0)
    assert rig.ask(Ask()).linear == pytest.approx(0.4, abs=0.03)
    rig.bench.near = 0.14
    at = rig.bench.x
    patrol(rig, 2.0)
    assert rig.bench.x - at < 0.13
    status = rig.ask(Ask())
    assert status.linear == pytest.approx(0.0, abs=0.02)
    assert status.angular > 0.5
    rig.bench.near = 0.2
    patrol(rig, 0.3)
    assert rig.ask(Ask()).angular > 0.5, "nothing is near, and the way is not clear yet"
    rig.bench.near = 0.8
    patrol(rig, 2.0)
    assert rig.ask(Ask()).linear == pytest.approx(0.4, abs=0.03)
    assert Event.REFLEX in events(rig)


def test_the_sonar_slows_down_and_stops_what_infrared_lets_pass(rig):
    """As before black glass: by hand, and nothing that drives back or turns."""
    rig.ask(Claim(7))
    drive(rig, 1.5, 0.4)
    assert rig.ask(Ask()).linear == pytest.approx(0.4, abs=0.03)
    rig.bench.far = 0.4
    drive(rig, 1.0, 0.4)
    assert rig.ask(Ask()).linear == pytest.approx(0.08, abs=0.02)
    rig.bench.far = 0.18
    drive(rig, 1.0, 0.4, 0.5)
    status = rig.ask(Ask())
    assert status.linear == pytest.approx(0.0, abs=0.02)
    assert status.angular == pytest.approx(0.5, abs=0.1)
    drive(rig, 1.0, -0.2)
    assert rig.ask(Ask()).linear == pytest.approx(-0.2, abs=0.03)


@pytest.mark.parametrize(("dead", "said"), [((0,), 1), ((1,), 2), ((0, 1), 3), ((), 0)])
def test_an_encoder_that_counts_nothing_while_its_side_is_driven_is_told(rig, dead, said):
    """Until the next motion, or until it counts again."""
    counts = rig.bench.encoders
    rig.bench.encoders = lambda: tuple(0 if side in dead else count for side, count in enumerate(counts()))
    rig.ask(Claim(7))
    assert rig.ask(Ask()).dead_encoders == 0
    drive(rig, 1.0, 0.1)
    assert rig.ask(Ask()).dead_encoders == said
    rig.rest()
    assert rig.ask(Ask()).dead_encoders == said
    rig.bench.encoders = counts
    drive(rig, 1.0, 0.1)
    assert rig.ask(Ask()).dead_encoders == 0


def test_rules_may_ask_for_any_reading(rig):
    activate(rig, b"warm")
    rig.ask(Claim(7))
    patrol(rig, 1.0)
    assert rig.ask(Ask()).linear == pytest.approx(0.1, abs=0.02)


def test_it_halts_before_it_turns():
    course = Course()
    assert course.velocity(0.8, 5.0, 0.3, 0.3) == (0.3, 0.0)
    assert course.velocity(0.14, 5.0, 0.3, 0.3) == (0.0, 0.0)
    assert course.velocity(0.14, 5.0, 0.0, 0.3) == (0.0, TURN_RAD_S)
    assert course.reflexes == 1
    assert course.velocity(0.8, 0.3, 0.0, 0.3) == (0.0, TURN_RAD_S), "the sonar sees something"
    assert course.velocity(0.8, 5.0, 0.0, 0.0) == (0.0, TURN_RAD_S), "the rules say that the way is closed"
    assert course.velocity(0.8, 5.0, 0.0, 0.3) == (0.3, 0.0)


def activate(rig, text):
    rig.firmware.flash.load(text)
    rig.firmware.flash.text()
    rig.say(HOLD)
    rig.ask(Claim(7))
    return rig.ask(Activate(7, crc_hqx(text, 0)))


def test_rules_come_by_xmodem_and_stay_in_flash(rig):
    text = b"speed 150\n"
    assert rig.say(b"X", 0.1) == b"C"
    block = text.ljust(128, b"\x1a")
    packet = b"\x01\x01\xfe" + block + crc_hqx(block, 0).to_bytes(2, "big")
    assert rig.say(packet) == b"\x06"
    answer = rig.say(b"\x04", 2.0)
    assert answer[:1] == b"\x06"
    assert protocol.count_of(answer[1:]) == 128
    assert protocol.checksum_of(rig.say(b"zC")) == crc_hqx(block.ljust(131064, b"\0"), 0)
    crc = crc_hqx(text, 0)
    rig.ask(Claim(7))
    assert rig.ask(Activate(7, crc ^ 1)) == Refusal("u", Reason.CHECKSUM)
    assert isinstance(rig.ask(Activate(7, crc)), Acknowledgement)
    assert rig.ask(Ask()).rules == crc
    assert protocol.count_of(rig.say(b"zw")) == 65536
    rig.firmware.restart()
    rig.pass_s(1.1)
    assert rig.ask(Ask()).rules == crc
    assert rig.firmware.flash.user == text.ljust(128, b"\x1a")
    assert rig.say(b"zc") == b"##zclear buffer\r\n"
    assert rig.say(b"zd") == b"##zdump: \r\n"
    rig.say(b"zr")
    assert rig.say(b"zd").startswith(b"##zdump: \r\nspeed 150\r\n")
    assert activate(rig, b"nonsense") == Refusal("u", Reason.RULES)
    assert rig.ask(Ask()).rules == crc


def test_a_block_that_is_spoilt_is_asked_for_again(rig):
    rig.say(b"X", 0.1)
    block = b"speed 150".ljust(128, b"\x1a")
    packet = b"\x01\x01\xfe" + block + b"\x12\x34"
    assert rig.say(packet, 3.0) == b"\x15"
    packet = packet[:-2] + crc_hqx(block, 0).to_bytes(2, "big")
    assert rig.say(packet) == rig.say(packet) == b"\x06", "the same block again is acknowledged, and left out"
    assert rig.say(b"\x04", 2.0).endswith(b"Count: 128\r\n")
    rig.say(b"X", 0.1)
    assert rig.say(b"", 80.0).endswith(b"##Xmodem receive error: -2\r\n"), "nobody sends"


def test_power_off_ends_all_but_the_flash(rig):
    rig.ask(Claim(7))
    drive(rig, 1.0)
    rig.firmware.restart()
    assert rig.notes[-2:] == [("rest", {"motion": 1, "end": "lost"}), ("power_on", {"boot": 2})]
    rig.pass_s(1.1)
    status = rig.ask(Ask())
    assert (status.boot, status.epoch, status.moving, status.journal) == (2, 0, False, 1)
    assert (status.x, status.y) == (1.0, 1.0)


def test_the_rules_that_it_was_made_with_are_the_papers():
    assert parse_text(text_of("srv1", MADE_WITH)) == PAPER


@pytest.mark.parametrize(
    "noise", [b"%", b"%" * 500, b"%v7,1e308,nan,0*0000\n", HOLD[:-3], b"%h*ffff\n", b"%a" + b"9" * 300 + b"\n"]
)
def test_what_is_no_frame_is_passed_over(rig, noise):
    rig.say(noise, 0.5)
    assert rig.ask(Ask()) is not None
    assert not rig.count("motion")


def test_a_frame_whose_numbers_are_out_of_bounds_is_refused(rig):
    body = b"v7,99999,0,0"
    answer = rig.say(b"%%%b*%04X\n" % (body, crc_hqx(body, 0)))
    assert answers.decode(Frames(ANSWER).feed(answer)[0]) == Refusal("v", Reason.BOUNDS)


def test_holding_at_rest_is_answered_and_holds_nothing(rig):
    status = rig.ask(Hold())
    assert (status.letter, status.holding, status.moving) == ("h", False, False)
