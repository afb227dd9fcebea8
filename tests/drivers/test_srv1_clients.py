"""The bytes that programs of others send to the rover, and the answers that they wait for, as its firmware has them."""

import cv2
import numpy as np
import pytest

from robots.kit.drivers.srv1.protocol import HEADER_BYTES, QUALITIES, PictureHeader
from simulators.srv1.imaging import jpeg
from tests.drivers.srv1_wire import JPEG, SEEN, Rig


@pytest.fixture
def rig():
    made = Rig(stock=True)
    yield made
    made.close()


def pictures(data):
    """Return the pictures in what was heard, as a client cuts them out by their headers."""
    found = []
    while data:
        header = PictureHeader.decode(data[:HEADER_BYTES])
        found.append(data[HEADER_BYTES:][: header.length])
        data = data[HEADER_BYTES + header.length :]
    return found


# pictures


def test_a_client_that_polls_for_pictures_without_waiting(rig):
    """Which of its letters come while a picture is sent is lost; each picture that comes is whole."""
    rig.heard.clear()
    for _ in range(100):
        rig.firmware.receive(b"I")
        rig.pass_s(0.007)
    rig.pass_s(0.1)
    found = pictures(bytes(rig.heard))
    assert 5 < len(found) < 50
    assert set(found) == {JPEG}


class Hasty(Rig):
    """A client that sends its next command 1 ms after an answer; this machine lets the firmware go on much later."""

    def __init__(self):
        self.commands = []
        super().__init__(stock=True)

    def hear(self, data):
        self.pass_s(0.001)
        if self.commands:
            self.firmware.receive(self.commands.pop(0))
        self.pass_s(0.5)
        return super().hear(data)


def test_a_client_that_goes_on_as_soon_as_it_has_the_whole_answer():
    """Nothing arrives before the serial port has sent it, so the next command finds the firmware free again."""
    rig = Hasty()
    rig.commands = [b"va4", b"vh", b"I", b"zC", b"I", b"V"]
    heard = rig.say(b"I", 5.0)
    assert not rig.commands
    assert heard.count(JPEG) == 3
    assert heard.endswith(b"2011\r\n")
    rig.close()


def test_a_client_that_sends_a_command_and_at_once_a_letter_for_a_picture(rig):
    """The picture is never sent; the client has to ask again."""
    assert rig.say(b"M\x32\x32\x05I", 0.5) == b"#M"
    assert rig.say(b"bI", 0.5) == b"#b"
    assert pictures(rig.say(b"I", 0.1)) == [JPEG]


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\0"])
def test_a_client_that_ends_each_command_like_a_line(rig, end):
    assert pictures(rig.say(b"I" + end, 0.1)) == [JPEG]
    assert rig.say(b"p" + end, 0.2).startswith(b"##ping ")
    assert rig.say(b"V" + end).startswith(b"##Version - SRV-1 Blackfin")


def test_a_client_that_sends_byte_after_byte(rig):
    for byte in b"M\x01\x01":
        assert rig.say(bytes((byte,)), 0.3) == b""
    assert rig.say(b"\x01", 0.1) == b"#M"
    for byte in b"vp016":
        assert rig.say(bytes((byte,)), 0.1) == b""
    assert rig.say(b"00120", 0.1).startswith(b"##vp ")


def test_the_quality_that_a_client_asks_for_changes_its_pictures(rig):
    sizes = []
    for quality in QUALITIES:
        assert rig.say(b"q%d" % quality) == b"##quality - %d\r\n" % quality
        (picture,) = pictures(rig.say(b"I", 0.1))
        assert picture == jpeg(SEEN, quality)
        sizes.append(len(picture))
    assert sorted(sizes, reverse=True) == sizes
    for odd, like in ((b"0", 1), (b"9", 8), (b"\xff", 8), (b"D", 4)):  # only four bits count
        assert rig.say(b"q" + odd) == b"##quality - %b\r\n" % odd
        assert pictures(rig.say(b"I", 0.1)) == [jpeg(SEEN, like)]
    rig.firmware.restart()
    rig.pass_s(1.1)
    rig.heard.clear()
    assert pictures(rig.say(b"I", 0.1)) == [JPEG]


def test_a_client_whose_camera_is_upside_down(rig):
    assert rig.say(b"y") == b"#y"
    (picture,) = pictures(rig.say(b"I", 0.1))
    read = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR)[::-1, ::-1, ::-1]
    assert np.abs(read.astype(int) - SEEN).mean() < 5
    assert rig.say(b"Y") == b"#Y"
    assert pictures(rig.say(b"I", 0.1)) == [JPEG]


# a client that looks for a ball


def test_its_automatic_exposure_and_white_balance_are_confirmed(rig):
    """A client that does not begin before it has this answer."""
    assert rig.say(b"b", 0.2) == b"#b"
    assert rig.say(b"q3") == b"##quality - 3\r\n"
    for mask in range(8):
        assert rig.say(b"va%d" % mask) == b"##va%d\r\n" % mask


def test_a_colour_is_stored_and_the_ball_is_found(rig):
    assert rig.say(b"vr3") == b"##vr 3 0 0 0 0 0 0\r\n"
    assert rig.say(b"vp01500080", 0.1) == b"##vp 147 45 205\r\n"
    assert rig.say(b"vb3", 0.1) == b"##vb3 0\r\n"
    assert rig.say(b"vc3140155040050200210") == b"##vc 3\r\n"
    assert rig.say(b"vr3") == b"##vr 3 140 155 40 50 200 210\r\n"
    assert rig.say(b"vb3", 0.1) == b"##vb3 1\r\n 1196 - 120 178 60 99  \r\n", "without its four corners"
    assert rig.say(b"vf30100020000500110", 0.1) == b"##vf 1200\r\n"
    assert rig.say(b"vf30100015000500080", 0.1) == b"##vf 300\r\n"
    assert rig.say(b"vz0") == b"##vzero\r\n"
    assert rig.say(b"vr3") == b"##vr 3 0 0 0 0 0 0\r\n"


def test_blobs_come_largest_first_and_a_gap_divides_them(rig):
    rig.bench.seen = SEEN.copy()
    rig.bench.seen[20:30, 20:40] = rig.bench.seen[100:180, 200:280] = SEEN[80, 150]
    rig.bench.seen[10, 300:302] = SEEN[80, 150]  # a lonely one
    rig.say(b"vcA140155040050200210")
    assert rig.say(b"vrA") == b"##vr 10 140 155 40 50 200 210\r\n"
    assert rig.say(b"vbA", 0.1) == (
        b"##vbA 3\r\n 3196 - 200 278 100 179  \r\n 1196 - 120 178 60 99  \r\n 96 - 20 38 20 29  \r\n"
    )


def test_the_mean_colour_and_how_colours_are_spread(rig):
    rig.bench.seen = SEEN[:200]
    assert rig.say(b"vm", 0.1) == b"##vmean 92 124 130\r\n"
    lines = rig.say(b"vh", 0.1).split(b"\r\n")
    assert lines[0] == b"##vhist"
    assert lines[1].startswith(b"      0  16  32")
    assert lines[4] == b"32" + b"    " * 12 + b" ***" + b"    " * 3, "the ball"
    assert lines[10] == b"128" + b"    " * 8 + b"****" + b"    " * 7
    assert lines[-2:] == [b"(U-axis)             2 regions", b""]


def test_edges_are_found_from_below_and_from_above(rig):
    rig.bench.seen = SEEN[:200]
    assert rig.say(b"vs4", 0.1) == b"##vscan = 276  200  100  100  200 \r\n"
    assert rig.say(b"vu4", 0.1) == b"##vhorizon = 276    0   59   59    0 \r\n"
    assert rig.say(b"vt9999") == b"##vthresh 9999\r\n"
    assert rig.say(b"vs2", 0.1) != rig.say(b"vt0000") == b"##vthresh 0\r\n"
    assert rig.say(b"T4") == b"#T"
    assert rig.say(b"vs1", 0.1) == b"##vscan = 276  100 \r\n"


def test_all_colours_are_divided_among_the_ranges(rig):
    bins = {b"1": b"5 64 127 0 127 128 255", b"2": b"5 0 255 64 127 64 127", b"3": b"5 0 255 96 127 96 127",
            b"4": b"5 80 95 0 255 0 255"}  # fmt: skip
    for kind, text in bins.items():
        assert rig.say(b"vz" + kind) == b"##vzero\r\n"
        assert rig.say(b"vr5") == b"##vr " + text + b"\r\n"


def test_a_busy_camera_finds_nothing_and_says_nothing(rig):
    rig.bench.seen = None
    for letters in (b"I", b"vb3", b"vm", b"vp00000000", b"vh", b"vs4"):
        assert rig.say(letters, 0.3) == b""
    assert rig.say(b"v\x01") == b""
    assert rig.say(b"V").startswith(b"##Version")


# what some clients send, on purpose or not


def test_the_range_of_its_lasers_where_no_spot_is_seen(rig):
    """It stops, looks three times, and divides by one."""
    rig.say(b"M\x3c\x3c\x00", 1.0)
    assert rig.say(b"R", 0.7) == b""
    assert not rig.bench.drive.moving
    assert rig.say(b"", 0.2) == b"##Range(cm) = 1920\r\n"
    rig.say(b"a", 0.2)
    *looks, words, answer, end = rig.say(b"r", 1.0).split(b"\r\n")
    assert len(looks) == 40
    assert looks[0] == b"right blobs: ymin=200   0 160 0 120 0  0 160 0 120 0  0 160 0 120 0"
    assert looks[-1] == b"left blobs: ymin=10   0 160 0 120 0  0 160 0 120 0  0 160 0 120 0"
    assert [words, answer, end] == [b"lconf 0 lrange 960 rconf 0 rrange 960", b"##Range(cm) = 960", b""]


def test_devices_that_are_read_by_their_registers(rig):
    assert rig.say(b"ir\x22\x41") == b"##ir22 0\r\n"
    assert rig.say(b"iR\x22\x41") == b"##iR22 0\r\n"
    assert rig.say(b"iM\x22\x41\x03") == b"##iM22  0 0 0 \r\n"
    assert rig.say(b"iM\x05\x410") == b"##iM 5  \r\n"
    assert rig.say(b"iW\x22\x01\x02") == b"", "an older spelling has one byte less: it waits for it"
    assert rig.say(b"\x03") == b"##iW22"


def test_a_letter_of_older_firmware_that_begins_a_request_for_a_web_page_now(rig):
    """A console has it on a button: for a second everything else that it sends is lost."""
    rig.say(b"G")
    assert rig.say(b"I", 0.5) == rig.say(b"M\x3c\x3c\x00", 0.3) == b""
    rig.pass_s(0.3)
    assert not rig.count("motion")
    assert pictures(rig.say(b"I", 0.1)) == [JPEG]
    rig.say(b"GET /robot.jpg HTTP/1.1\r\nHost: rover\r\n\r\n", 0.01)
    assert rig.say(b"V").startswith(b"##Version"), "an empty line ends it"
    rig.say(b"POST /admin HTTP/1.1\r\n\r\n", 0.9)
    assert rig.say(b"V", 0.9) == rig.say(b"V", 0.9) == b"", "a file ends with a second of silence"
    rig.pass_s(0.2)
    assert rig.say(b"V").startswith(b"##Version")


def test_motors_and_boards_that_it_does_not_have(rig):
    assert rig.say(b"m\x3c\x3c\x32", 0.4) == b""
    assert rig.say(b"", 0.2) == b"#m"
    assert rig.say(b"s\x32\x32") == b"#s"
    assert rig.say(b"x") == b"#x", "before it has its two arguments"
    assert rig.say(b"\x01") == rig.say(b"\x01") == b""
    assert rig.say(b"V").startswith(b"##Version")
    assert not rig.count("motion")
