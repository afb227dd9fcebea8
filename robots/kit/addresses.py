"""Checks of the addresses of robots, cameras and microphones: when staff save one, and again before it is opened.

The portal opens addresses that staff write down, from a machine that may stand in a cloud or beside other devices.
Addresses of machine services (link-local, cloud metadata) and files outside /dev are never opened.
"""

import ipaddress
import re
import socket
import ssl
from pathlib import Path
from urllib.parse import urlsplit

METADATA = frozenset({"fd00:ec2::254", "100.100.100.200", "168.63.129.16"})  # cloud metadata, not link-local
SHAPE = "Use sim:NAME, serial:/dev/PORT or tcp:HOST:PORT."
CAMERA_SHAPE = "Use http(s)://…, rtsp://… or v4l2:/dev/videoN, one camera a line."
SIMULATED = "sim:microphone"
MICROPHONE_SHAPE = f"Use http(s)://…, rtsp://…, alsa:default, alsa:hw:1,0 or {SIMULATED}."
# no other plug-in of ALSA: some of them open files or start programs
ALSA = r"alsa:(default|(plughw|hw|sysdefault|dsnoop):(CARD=)?[A-Za-z0-9_-]{1,32}(,(DEV=)?[0-9]{1,3}){0,2})"
FORBIDDEN = "{} is an address of a machine's own services; no robot, camera or microphone can be there."
HIDDEN = "***"
_SECRET = re.compile(
    r"(?<![\w-])((?:[\w-]{0,40}(?:pas|pwd|secret|token|key|auth|sig|credential)[\w-]{0,40}|pw)=)[^\s&;#,'\"<>]+",
    re.IGNORECASE,
)
_SCHEME = re.compile(  # of the header Authorization; Digest has several values
    r"\b(Basic|Bearer|Digest) (?!auth)[^\s'\"]+(?:\"[^\s\"]*\")?(?:, \w+=(?:\"[^\"]*\"|[^\s,]+))*"
)


def redacted(text: str) -> str:
    """Return a text without the user, the password and the secret values that stand in its addresses.

    `http://user:password@host/a?pwd=b` becomes `http://***@host/a?pwd=***`, with or without a scheme. Where it is not
    clear where a password ends, up to the last @ of the word is left out. Mail addresses stay. `Basic YTpi`, as in the
    header `Authorization`, becomes `Basic ***`.
    """
    return re.sub(r"\S+", _redacted_word, _SCHEME.sub(rf"\1 {HIDDEN}", text))


def _redacted_word(found: re.Match[str]) -> str:
    word = found[0]
    at = word.rfind("@")
    colon = word.find(":", 0, max(at, 0))
    if colon >= 0:
        begin = colon + 3 if word.startswith("://", colon) else len(word) - len(word.lstrip("'\"([{<"))
        word = f"{word[:begin]}{HIDDEN}{word[at:]}"
    return _SECRET.sub(rf"\1{HIDDEN}", word)


class AddressError(ValueError):
    """The address may not be used; the message says why."""

    def __str__(self) -> str:
        """Return the message without the secrets of addresses: people read it."""
        return redacted(super().__str__())


def check_host(host: str) -> None:
    """Refuse a numeric address that cannot be a robot's; names are checked by `check_resolved`. Raises AddressError."""
    text = host.strip("[]").partition("%")[0]
    try:
        ip = ipaddress.ip_address(text)
    except ValueError:
        _check_name(text)
        return
    ip = getattr(ip, "ipv4_mapped", None) or ip
    if ip.is_link_local or ip.is_multicast or ip.is_unspecified or str(ip) in METADATA:
        raise AddressError(FORBIDDEN.format(host))


def _check_name(name: str) -> None:
    """Refuse numbers in other notations (2852039166, 0xA9FEA9FE, 0251.0376…), which systems read as addresses."""
    if re.fullmatch(r"(0[xX][0-9a-fA-F]*|[0-9]+)(\.(0[xX][0-9a-fA-F]*|[0-9]+)){0,3}", name):
        raise AddressError(f"Write {name} as four numbers with dots, or as a name.")
    if not re.fullmatch(r"[A-Za-z0-9]([\w-]*[A-Za-z0-9])?(\.[A-Za-z0-9]([\w-]*[A-Za-z0-9])?)*\.?", name, re.ASCII):
        raise AddressError(f"{name!r} is not the name of a machine.")


def check_resolved(host: str, port: int) -> None:
    """Look up a name and refuse it if `check_host` refuses one of its addresses. Raises AddressError."""
    check_host(host)
    try:
        found = socket.getaddrinfo(host.strip("[]"), port, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError):  # the latter: a part of the name is longer than names may be
        return  # opening it will fail with its own message
    for *_, place in found:
        check_host(str(place[0]))


def http_options(scheme: str) -> dict[str, str]:
    """Return FFmpeg's options for such an address: no redirect is followed, and a certificate is checked, as by Python.

    Own authorities stand in the file that the environment names as SSL_CERT_FILE, for both. Empty for other schemes.
    """
    options = {"max_redirects": "0"} if scheme in ("http", "https") else {}
    if scheme == "https":
        options["tls_verify"] = "1"
        if authorities := ssl.get_default_verify_paths().cafile:
            options["ca_file"] = authorities
    return options


def check_robot(address: str) -> None:
    """Refuse text that is not the address of a robot. Raises AddressError."""
    kind, _, rest = address.partition(":")
    if kind == "sim" and re.fullmatch(r"[a-z0-9_]+", rest):
        return
    if kind == "serial" and re.fullmatch(r"/dev/[\w.:/+-]+", rest, re.ASCII):
        _check_device(rest)
        return
    host, _, port = rest.rpartition(":")
    if kind != "tcp" or not host or not re.fullmatch(r"[0-9]{1,5}", port) or not 0 < int(port) < 65_536:
        raise AddressError(SHAPE)
    check_host(host)


def check_robot_now(address: str) -> None:
    """Check an address again just before it is opened, with its name looked up. Raises AddressError."""
    check_robot(address)
    kind, _, rest = address.partition(":")
    if kind == "tcp":
        host, _, port = rest.rpartition(":")
        check_resolved(host, int(port))


def _check_device(path: str) -> None:
    if ".." in path.split("/"):
        raise AddressError("The port's path must not contain '..'.")
    real = Path(path).resolve()
    if Path("/dev") not in real.parents or Path("/dev/shm") in real.parents:  # noqa: S108 - refused, not used
        raise AddressError(f"{path} leads to {real}, which is not a device under /dev.")


def check_cameras(text: str) -> None:
    """Refuse text that is not a list of camera addresses. Raises AddressError."""
    for address in text.split():
        if re.fullmatch(r"v4l2:/dev/video[0-9]{1,3}", address):
            continue
        _check_network(address, CAMERA_SHAPE)


def check_microphone(text: str) -> None:
    """Refuse text that is not the address of a microphone. Raises AddressError."""
    if text == SIMULATED or re.fullmatch(ALSA, text, re.ASCII):
        return
    if re.search(r"\s", text):
        raise AddressError(MICROPHONE_SHAPE)
    _check_network(text, MICROPHONE_SHAPE)


def _check_network(address: str, shape: str) -> None:
    try:
        parts = urlsplit(address)
        host, _ = parts.hostname, parts.port
    except ValueError as error:
        raise AddressError(shape) from error
    if parts.scheme not in ("http", "https", "rtsp") or not host:
        raise AddressError(shape)
    check_host(host)
