"""Posts to an address that somebody has given: over HTTPS, to a judged address, without redirects, in limited time.

The name is looked up once and that address is connected to, so it cannot change after it was judged.
"""

import contextlib
import http.client
import ipaddress
import socket
import ssl
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import SplitResult, urlsplit

from robots.kit.addresses import check_host

NAT64 = ipaddress.ip_network("64:ff9b::/96")  # an IPv4 address in its last four bytes
COMPATIBLE = ipaddress.ip_network("::/96")  # likewise


class NotReached(Exception):
    """The other side did not answer, or may not be connected to; the text says why."""


class NotPublic(NotReached):
    """The address is one of a private network."""


@dataclass(frozen=True)
class Limits:
    """The limits of one request (s): `each` step of the connection, and `all` of it."""

    each: float
    all: float


def https_parts(url: str) -> SplitResult:
    """Return the parts of an address. Raises ValueError if it is not HTTPS with a host, without user and fragment."""
    parts = urlsplit(url)
    if parts.scheme != "https" or not parts.hostname or parts.username or parts.password or parts.fragment:
        raise ValueError("not an address that begins with https://, without user and password")
    _ = parts.port  # ValueError if it is none
    return parts


def is_public(address: str) -> bool:
    """Return whether a numeric address is one of the internet, also inside the IPv6 forms that lead to IPv4."""
    ip = ipaddress.ip_address(address.partition("%")[0])
    if isinstance(ip, ipaddress.IPv6Address):
        inner = ip.ipv4_mapped or ip.sixtofour
        if ip in NAT64 or ip in COMPATIBLE:
            inner = ipaddress.IPv4Address(int(ip) & 0xFFFFFFFF)
        if inner is not None:
            return is_public(str(inner))
        if ip.is_site_local:
            return False
    return ip.is_global and not ip.is_multicast


def post(url: str, body: bytes, headers: Mapping[str, str], limits: Limits, private: bool) -> int:
    """Post and return the status of the answer, whose body is not read; `private`: also to private networks.

    Raises NotReached.
    """
    try:
        parts = https_parts(url)
        port = parts.port or 443
        place = _place(parts.hostname or "", port, private)
        return _request(_Pinned(parts.hostname or "", port, place, limits.each), parts, body, headers, limits)
    except (OSError, http.client.HTTPException, ValueError) as error:
        raise NotReached(f"{error or type(error).__name__}") from error


def _place(host: str, port: int, private: bool) -> str:
    """Return the numeric address to connect to. Raises OSError, ValueError, NotPublic."""
    check_host(host)
    found = [str(place[0]) for *_, place in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)]
    for one in found:
        check_host(one)
        if not private and not is_public(one):
            raise NotPublic(f"{one} is a private address")
    if not found:
        raise OSError("its name has no address")
    return found[0]


def tls() -> ssl.SSLContext:
    """Return how certificates are checked: as everywhere, by the system's authorities or SSL_CERT_FILE."""
    return ssl.create_default_context()


class _Pinned(http.client.HTTPSConnection):
    """A connection to a host at an address that was judged before."""

    def __init__(self, host: str, port: int, place: str, each_s: float) -> None:
        self._tls, self._place, self._each_s = tls(), place, each_s
        super().__init__(host, port, timeout=each_s, context=self._tls)

    def connect(self) -> None:
        line = socket.create_connection((self._place, self.port), timeout=self._each_s)
        self.sock = line  # known before the handshake, so that it can be ended
        self.sock = self._tls.wrap_socket(line, server_hostname=self.host)

    def cut(self) -> None:
        """End whatever goes on."""
        if self.sock is not None:
            with contextlib.suppress(OSError):
                self.sock.shutdown(socket.SHUT_RDWR)


def _request(connection: _Pinned, parts: SplitResult, body: bytes, headers: Mapping[str, str], limits: Limits) -> int:
    # a peer that sends a byte now and then is within each step's limit
    limit = threading.Timer(limits.all, connection.cut)
    limit.daemon = True
    limit.start()
    try:
        target = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
        connection.request("POST", target, body, {**headers, "Connection": "close"})
        return connection.getresponse().status
    finally:
        limit.cancel()
        connection.close()
