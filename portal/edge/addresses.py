"""The network address of a request: which proxies are trusted, and which addresses count as one."""

import ipaddress


def proxy_networks(entries: list[str]) -> list[str]:
    """Return the networks of trusted proxies in canonical form.

    Raises:
        ValueError: an entry is not a network, or trusts everybody; the message says which one and what to write.
    """
    found = []
    for entry in (e.strip() for e in entries if e.strip()):
        if entry.isdecimal():
            raise ValueError(
                f"FARHAND_TRUSTED_PROXIES is no longer a number of hops ({entry}): name the addresses or networks "
                "of your own proxies, for example 127.0.0.1,10.0.3.0/28, or leave it empty where there is none."
            )
        try:
            network = ipaddress.ip_network(entry)
        except ValueError as error:
            raise ValueError(
                f"FARHAND_TRUSTED_PROXIES: {entry!r} is neither an IP address nor a network ({error})."
            ) from error
        if network.prefixlen == 0:
            raise ValueError(f"FARHAND_TRUSTED_PROXIES: {entry} would let everybody choose the address they have.")
        found.append(str(network))
    return found


def network_of(address: str) -> str:
    """Return the key under which an address is counted: an IPv4 address, an IPv6 /64, or the text itself."""
    try:
        ip = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address[:64]
    if isinstance(ip, ipaddress.IPv4Address):
        return str(ip)
    if ip.ipv4_mapped is not None:
        return str(ip.ipv4_mapped)
    return str(ipaddress.ip_network((ip, 64), strict=False))
