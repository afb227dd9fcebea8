"""Networks of trusted proxies, and which addresses count as one."""

import pytest

from portal.edge.addresses import network_of, proxy_networks


def test_networks_and_single_addresses_are_taken():
    assert proxy_networks(["127.0.0.1", " 10.0.3.0/28 ", "", "2001:db8::/64"]) == [
        "127.0.0.1/32", "10.0.3.0/28", "2001:db8::/64",
    ]  # fmt: skip
    assert proxy_networks([]) == []


@pytest.mark.parametrize("entry", ["0", "1", "2"])
def test_the_old_number_of_hops_is_refused_with_what_to_write(entry):
    with pytest.raises(ValueError, match="no longer a number of hops.*name the addresses"):
        proxy_networks([entry])


@pytest.mark.parametrize("entry", ["*", "0.0.0.0/0", "::/0", "proxy.example.org", "10.0.3.1/28", "10.0.0", "²"])
def test_what_is_no_network_or_trusts_everybody_is_refused(entry):
    with pytest.raises(ValueError, match="FARHAND_TRUSTED_PROXIES"):
        proxy_networks([entry])


@pytest.mark.asvs("2.4.1")
def test_one_ipv6_network_counts_as_one_address():
    assert network_of("2001:db8:1:2::1") == network_of("2001:db8:1:2:ffff:ffff:ffff:ffff") == "2001:db8:1:2::/64"
    assert network_of("2001:db8:1:3::1") != network_of("2001:db8:1:2::1")
    assert network_of("::ffff:192.0.2.7") == network_of("192.0.2.7") == "192.0.2.7"
    assert network_of("fe80::1%eth0") == "fe80::/64"
    assert network_of("unix:") == "unix:"
    assert len(network_of("x" * 10_000)) == 64
