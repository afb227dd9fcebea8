"""Where robots and cameras may be."""

import socket

import pytest

from robots.kit import addresses
from robots.kit.contract.errors import CameraFault

FORBIDDEN = [
    "169.254.169.254", "169.254.0.1", "[fe80::1]", "[fe80::1%eth0]", "[::ffff:169.254.169.254]", "[fd00:ec2::254]",
    "100.100.100.200", "0.0.0.0", "[::]", "224.0.0.1", "2852039166", "0xA9FEA9FE", "0251.0376.0251.0376", "169.254.43518",
    "-x", "a..b", "a b", "a\0b", "user@host", "",
]  # fmt: skip


@pytest.mark.parametrize("address", [
    "sim:mercury", "serial:/dev/ttyUSB0", "serial:/dev/serial/by-id/usb-FTDI_1-if00-port0", "tcp:127.0.0.1:4001",
    "tcp:arm.example.org:8101", "tcp:192.168.1.20:1", "tcp:[fd12::1]:65535", "tcp:[::1]:7",
])  # fmt: skip
def test_robots_addresses(address):
    addresses.check_robot(address)


@pytest.mark.asvs("1.3.6", "15.3.2")
@pytest.mark.parametrize("address", [
    "", "sim:", "sim:../x", "http://x", "file:///etc/passwd", "serial:/etc/passwd", "serial:/dev/../etc/passwd",
    "serial:/dev/shm/x", "serial:/dev/stdin/../../etc/passwd", "serial:/dev/fd/0/x y", "serial:dev/ttyUSB0", "tcp:host", "tcp:host:0",
    "tcp:host:65536", "tcp:host:²", "tcp:host:" + "9" * 5000, "tcp::1", "socket://x:1", *(f"tcp:{h}:80" for h in FORBIDDEN),
])  # fmt: skip
def test_what_is_no_robots_address(address):
    with pytest.raises(addresses.AddressError):
        addresses.check_robot(address)


def test_a_port_that_leads_out_of_dev_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(addresses.Path, "resolve", lambda self: tmp_path / "x")
    with pytest.raises(addresses.AddressError, match="is not a device"):
        addresses.check_robot("serial:/dev/ttyUSB0")


@pytest.mark.parametrize(
    "text", ["", "v4l2:/dev/video0", "http://cam.example.org/snapshot.jpg\nrtsp://192.168.1.9:554/live"]
)
def test_cameras_addresses(text):
    addresses.check_cameras(text)


@pytest.mark.asvs("1.3.6", "15.3.2")
@pytest.mark.parametrize("text", [
    "file:///etc/passwd", "gopher://x/", "v4l2:/dev/video0/../sda", "http://", "http://[", "http://x:99999/",
    "http://a/ http://169.254.169.254/latest", "concat:http://x", *(f"http://{h}/" for h in FORBIDDEN if h and " " not in h and "@" not in h),
])  # fmt: skip
def test_what_is_no_cameras_address(text):
    with pytest.raises(addresses.AddressError):
        addresses.check_cameras(text)


@pytest.mark.parametrize("text", [
    "sim:microphone", "alsa:default", "alsa:hw:1,0", "alsa:plughw:CARD=Mic_1,DEV=0", "http://mic.example.org:8000/live.opus",
    "https://[fd12::1]/a.wav", "rtsp://user:secret@192.168.1.9:554/audio",
])  # fmt: skip
def test_microphones_addresses(text):
    addresses.check_microphone(text)


@pytest.mark.asvs("1.3.6", "15.3.2")
@pytest.mark.parametrize("text", [
    "", "sim:mercury", "alsa:", "alsa:file:/etc/passwd", "alsa:default:{FILE |id}", "alsa:hw:1;x", "alsa:hw:1,0\n", "file:///etc/passwd",
    "/dev/snd/pcmC0D0c", "http://a/ http://b/", "http://a/\nx", "http://", "http://x:99999/", "concat:http://x", "udp://239.1.1.1:5004",
    *(f"http://{h}/" for h in FORBIDDEN if h and " " not in h and "@" not in h),
])  # fmt: skip
def test_what_is_no_microphones_address(text):
    with pytest.raises(addresses.AddressError):
        addresses.check_microphone(text)


def test_a_name_that_leads_there_is_refused_when_it_is_opened(monkeypatch):
    monkeypatch.setattr(socket, "getaddrinfo", lambda *a, **k: [(2, 1, 6, "", ("169.254.169.254", 80))])
    with pytest.raises(addresses.AddressError):
        addresses.check_resolved("innocent.example.org", 80)


@pytest.mark.asvs("1.3.6", "15.3.2")
def test_a_camera_whose_name_leads_there_is_sent_nothing(monkeypatch, tmp_path):
    from workers.media.source import SnapshotCamera

    sent = []
    monkeypatch.setattr(addresses, "check_resolved", lambda *a: (_ for _ in ()).throw(addresses.AddressError("no")))
    monkeypatch.setattr(socket, "create_connection", lambda *a, **k: sent.append(a))
    with pytest.raises(CameraFault):
        SnapshotCamera("http://innocent.example.org/snapshot.jpg").grab(0.01)
    assert not sent
