"""How many messages a network address may send, over all its sockets."""

from hypothesis import given
from hypothesis import strategies as st

from portal.edge import limits
from portal.edge.limits import AddressRate


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def test_an_address_may_send_a_burst_and_then_so_many_a_second():
    clock = Clock()
    rate = AddressRate(10.0, 30.0, clock)
    assert sum(rate.take("192.0.2.1") for _ in range(100)) == 30
    assert rate.take("192.0.2.2"), "another address"
    clock.now += 2.0
    assert sum(rate.take("192.0.2.1") for _ in range(100)) == 20
    assert sum(rate.take(f"2001:db8::{n:x}") for n in range(100)) == 30, "a /64 is one"


@given(st.lists(st.tuples(st.integers(0, 3), st.floats(0, 5)), max_size=200))
def test_none_ever_sends_more_than_the_rule(steps):
    clock = Clock()
    rate, sent = AddressRate(2.0, 5.0, clock), {}
    for which, seconds in steps:
        clock.now += seconds
        address = f"192.0.2.{which}"
        sent[address] = sent.get(address, 0) + rate.take(address)
        assert sent[address] <= 5 + 2.0 * clock.now + 1e-6


def test_those_that_are_calm_are_forgotten(monkeypatch):
    monkeypatch.setattr(limits, "MANY", 10)
    clock = Clock()
    rate = AddressRate(1.0, 3.0, clock)
    for n in range(10):
        rate.take(f"192.0.2.{n}")
    for _ in range(3):
        rate.take("192.0.2.99")
    assert len(rate._buckets) == 11, "none is calm yet"
    clock.now += 1.5
    rate.take("192.0.2.100")
    assert set(rate._buckets) == {"192.0.2.99", "192.0.2.100"}
