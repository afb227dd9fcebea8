"""No text argument of any command takes what no database stores, whatever the robot's own rules leave out."""

import pytest

from robots.kit.contract.errors import BadRequest
from robots.kit.contract.find import spec_of
from robots.kit.contract.values import check
from robots.kit.drivers.srv1.rules import paper

DRIVERS = ("irat", "mercury", "pa10", "so101", "srv1")
COMMANDS = [(name, c) for name in DRIVERS for c in spec_of(name).commands]
TEXTS = [(name, c.kind, a) for name, c in COMMANDS for a in c.arguments if a.text]
BEGINS = {
    ("srv1", "mission"): "photograph", ("srv1", "rules"): paper().strip(), ("pa10", "program"): "d 1",
    ("pa10", "task"): "wait 1",
}  # fmt: skip
NEVER = pytest.mark.parametrize("never", ["\0", "\ud800", "\udfff"], ids=["NUL", "high half", "low half"])


def test_the_texts_of_all_robots_are_known_here():
    assert {(name, kind) for name, kind, _ in TEXTS} == set(BEGINS)


@NEVER
@pytest.mark.parametrize(("name", "kind", "argument"), TEXTS, ids=lambda one: getattr(one, "name", one))
def test_a_comment_hides_nothing_that_cannot_be_stored(name, kind, argument, never):
    begins = BEGINS[name, kind]
    check(name, kind, {argument.name: f"# a comment\n{begins}"}, {})
    with pytest.raises(BadRequest, match=f"value {argument.name} .* cannot be stored"):
        check(name, kind, {argument.name: f"# {never}\n{begins}"}, {})
