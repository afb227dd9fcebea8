"""Ports and connections that cannot be opened: absent, forbidden, in use or something else, in words with what to do."""

import errno
import os
import pty
import socket
import termios
from pathlib import Path

import av
import pytest
import serial
from hypothesis import given
from hypothesis import strategies as st

from robots.kit import opening
from robots.kit.contract.errors import PLAIN, CameraFault, LineBusy, LineGone, why
from robots.kit.drivers.mercury import protocol
from robots.kit.drivers.pa10.line import ArmLine
from robots.kit.drivers.rosbridge_client import Bridge
from robots.kit.drivers.serial_line import SerialLine
from robots.kit.opening import is_in_use, why_not
from robots.sentences import _sentences
from tests.waiting import CEILING_S, wait_for
from workers.media import microphone, source
from workers.media.microphone import Microphone, MicrophoneFault
from workers.media.source import SnapshotCamera, StreamCamera


def opened(address):
    """Return the fault with which a serial line to that address does not open."""
    line = SerialLine(protocol, address, protocol.BAUD, 1, None)
    with pytest.raises((LineGone, LineBusy)) as caught:
        line.open()
    return caught.value


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def said_by(camera, monkeypatch):
    """Return what a camera says after its first attempt to open, which failed."""
    try:
        wait_for(lambda: camera._error, 30, "the end of the first attempt")
    finally:
        camera.close()
    monkeypatch.setattr(source, "TIMEOUT_S", 0.1)  # of a picture, for which nobody needs to wait any more
    with pytest.raises(CameraFault) as said:
        camera.grab(None)
    return str(said.value)


def test_a_port_that_is_not_there(tmp_path):
    fault = opened(str(tmp_path / "ttyUSB7"))
    assert str(fault) == f"The robot's serial port cannot be opened: {opening.ABSENT}"
    assert str(tmp_path) not in str(fault), "everybody reads it"


def test_a_link_that_leads_nowhere(tmp_path):
    (tmp_path / "by-id").symlink_to(tmp_path / "ttyUSB7")
    assert str(opened(str(tmp_path / "by-id"))).endswith(opening.DANGLING)


def test_what_is_no_serial_port(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    for path in ("/dev/null", str(tmp_path / "file"), str(tmp_path)):
        assert str(opened(path)).endswith(opening.NO_TTY), path


def test_a_port_that_another_program_holds():
    master, slave = pty.openpty()
    try:
        with serial.Serial(os.ttyname(slave), exclusive=True):
            fault = opened(os.ttyname(slave))
    finally:
        os.close(master)
        os.close(slave)
    assert isinstance(fault, LineBusy)
    assert str(fault).endswith(opening.IN_USE)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may open everything")
def test_a_port_that_the_portal_may_not_open(tmp_path):
    (tmp_path / "tty").touch(0o000)
    assert str(opened(str(tmp_path / "tty"))).endswith(opening.NO_GROUP)


@pytest.mark.parametrize("number", [errno.EACCES, errno.EPERM])
def test_who_may_open_it_is_said_by_the_group_of_the_device(tmp_path, monkeypatch, number):
    device = tmp_path / "tty"
    device.touch()
    refused = PermissionError(number, "Permission denied")
    assert why_not(refused, str(device)) == opening.NO_GROUP
    device.chmod(0o660)
    monkeypatch.setattr(opening.Path, "stat", lambda path: os.stat_result((0o20660, 0, 0, 1, 0, 20, 0, 0, 0, 0)))
    monkeypatch.setattr(opening.grp, "getgrgid", lambda gid: type("Group", (), {"gr_name": {20: "dialout"}[gid]}))
    assert "Add the portal's user to the group dialout" in why_not(refused, str(device))


@pytest.mark.parametrize("make", [lambda a: SerialLine(protocol, f"socket://{a}", protocol.BAUD, 1, None), lambda a: ArmLine(a, 1, "", None), Bridge], ids=["serial server", "arm", "rosbridge"])  # fmt: skip
def test_a_connection_that_is_refused_and_a_name_that_nobody_knows(make):
    for address, words in ((f"127.0.0.1:{free_port()}", opening.REFUSED), ("robot.invalid:9090", opening.NO_NAME)):
        with pytest.raises(LineGone) as caught:
            make(address).open()
        assert str(caught.value).endswith(words)


def test_cameras_say_it_too(tmp_path):
    with pytest.raises(CameraFault, match=f"does not answer: {opening.REFUSED}"):
        SnapshotCamera(f"http://127.0.0.1:{free_port()}/a.jpg").grab(None)
    camera = StreamCamera(str(tmp_path / "video9"), "v4l2")
    try:
        with pytest.raises(CameraFault) as caught:
            camera.grab(None)
    finally:
        camera.close()
    assert str(caught.value) == f"The camera does not answer: {opening.ABSENT}"


WRAPPED = {
    errno.EHOSTUNREACH: opening.NO_ROUTE, errno.ENETUNREACH: opening.NO_ROUTE, errno.ETIMEDOUT: opening.SILENT,
    errno.EBUSY: opening.IN_USE, errno.ENXIO: opening.BROKEN, errno.ENODEV: opening.BROKEN, errno.EIO: opening.BROKEN,
}  # fmt: skip


@given(number=st.sampled_from(sorted(WRAPPED)), depth=st.integers(0, 3))
def test_the_system_s_word_is_read_through_what_libraries_wrap_around_it(number, depth):
    error: Exception = OSError(number, os.strerror(number))
    for _ in range(depth):
        try:
            raise serial.SerialException("could not open port") from error
        except serial.SerialException as wrapped:
            error = wrapped
    assert why_not(error, "/dev/nothing") == WRAPPED[number]
    assert is_in_use(error) is (number == errno.EBUSY)


def test_an_error_of_the_terminal_has_its_number_among_its_arguments():
    assert why_not(termios.error(errno.ENOTTY, "Inappropriate ioctl"), "/dev/nothing") == opening.NO_TTY
    assert why_not(TimeoutError("timed out")) == opening.SILENT
    assert why_not(ValueError("something odd")) == "something odd."


def test_a_number_in_another_error_is_none_of_the_system_s():
    for path in ("", "/dev/nothing"):
        assert why_not(KeyError(errno.EIO), path) == "5."
        assert why_not(ValueError(errno.EBUSY), path) == "16."
    assert not is_in_use(ValueError(errno.EBUSY))


@pytest.mark.parametrize(
    "number", [errno.EIO, errno.EINVAL, errno.EAGAIN, errno.ENXIO, errno.ENODEV, errno.EBUSY, errno.EACCES]
)
def test_nothing_that_a_connection_raises_is_said_of_a_device(number):
    told = why_not(OSError(number, os.strerror(number)))
    assert told not in (opening.BROKEN, opening.NO_TTY, opening.IN_USE, opening.ABSENT, opening.NO_GROUP), told


@pytest.mark.parametrize(("address", "words"), [
    ("rtsp://camera.invalid/a", opening.LOST), ("http://camera.invalid/a.mjpg", opening.LOST),
    ("tcp://camera.invalid:9000", opening.LOST), ("udp://camera.invalid:9000", opening.LOST),
    ("tcp://127.0.0.1:0", opening.WRONG),
])  # fmt: skip
def test_a_stream_that_does_not_open_is_no_broken_device(monkeypatch, address, words):
    monkeypatch.setattr(source, "TIMEOUT_S", CEILING_S)
    monkeypatch.setattr(microphone, "TIMEOUT_S", CEILING_S)
    with pytest.raises(av.FFmpegError) as caught:
        av.open(address, timeout=(CEILING_S, CEILING_S))
    told = why_not(caught.value)
    assert told == words, caught.value
    assert said_by(StreamCamera(address), monkeypatch) == f"The camera does not answer: {words}"
    if address.startswith(("http", "rtsp")):
        with pytest.raises(MicrophoneFault, match=words):
            Microphone(address, Path("/nowhere"))


@pytest.fixture
def mute():
    """The port of a server that takes connections and never says a word."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server.getsockname()[1]


@pytest.mark.parametrize("scheme", ["http", "https", "rtsp"])
def test_what_does_not_answer_in_time_is_said_to_be_silent_however_the_library_says_it(mute, monkeypatch, scheme):
    monkeypatch.setattr(source, "TIMEOUT_S", 0.3)
    monkeypatch.setattr(microphone, "TIMEOUT_S", 0.3)
    address = f"{scheme}://127.0.0.1:{mute}/live"
    with pytest.raises(MicrophoneFault, match=opening.SILENT):
        Microphone(address, Path("/nowhere"))
    assert said_by(StreamCamera(address), monkeypatch) == f"The camera does not answer: {opening.SILENT}"


def test_every_sentence_says_what_to_do():
    said = {v for k, v in vars(opening).items() if k.isupper() and isinstance(v, str)}
    assert len(said) > 9
    for text in said:
        assert text.endswith(".")
        assert any(word in text for word in ("Plug", "Add ", "Give ", "End ", "Correct", "Start ", "Look ", "Pull ")), (
            text
        )


@pytest.mark.parametrize("number", sorted(PLAIN))
def test_what_the_system_says_of_a_usual_fault_is_in_plain_words(number):
    error = OSError(number, os.strerror(number), "/secret/path")
    assert why(error) == PLAIN[number]
    german = _sentences("de").translate(f"The connection to the rover broke: {why(error)}.")
    assert german.startswith("Die Verbindung")
    assert PLAIN[number] not in german


def test_a_socket_that_is_not_there_is_told_in_plain_words(tmp_path):
    with socket.socket(socket.AF_UNIX) as line, pytest.raises(FileNotFoundError) as failed:
        line.connect(str(tmp_path / "nothing"))
    assert why_not(failed.value) == opening.REFUSED
