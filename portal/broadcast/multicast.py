"""UDP sockets of a multicast group (IPv4) on one interface of the machine."""

import ipaddress
import socket
import struct

BUFFER = 4 * 1024 * 1024  # bytes that may wait for an edge that is busy: some seconds


def group_of(text: str) -> tuple[str, int]:
    """Return the group and its port of `239.x.y.z:port`. Raises ValueError."""
    address, _, port = text.rpartition(":")
    try:
        known = ipaddress.IPv4Address(address)
    except ValueError:
        known = None
    if known is None or not known.is_multicast or not (port.isdecimal() and 0 < int(port) < 2**16):
        raise ValueError(f"{text!r} is no multicast group, as 239.8.1.30:5004.")
    return address, int(port)


def _request(group: str, interface: str) -> bytes:
    """Return the `ip_mreqn` of a group on an interface. Raises OSError where there is none of that name."""
    return struct.pack("4s4si", socket.inet_aton(group), bytes(4), socket.if_nametoindex(interface))


def sender(interface: str, hops: int = 1) -> socket.socket:
    """Return a socket that sends to groups by this interface, so many hops far. Raises OSError."""
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        line.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, _request("0.0.0.0", interface))  # noqa: S104 - none
        line.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, hops)
        line.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)  # edges on this machine hear it, too
        line.setblocking(False)
    except OSError:
        line.close()
        raise
    return line


def receiver(group: tuple[str, int], interface: str) -> socket.socket:
    """Return a socket that hears this group alone, beside others on the machine that do. Raises OSError."""
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        line.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
        line.bind(group)
        line.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, _request(group[0], interface))
        line.setblocking(False)
    except OSError:
        line.close()
        raise
    return line
