"""The list of promises and the tests that name them agree."""

import re

from tests import proofs


def test_every_promise_has_a_test_or_a_reason():
    assert not [n for n in proofs.PROMISES if not (proofs.tests_of(n) or n in proofs.ELSEWHERE)]


def test_every_test_named_beside_is_there():
    names = [name.partition("::") for told in proofs.TESTED.values() for name in told]
    for file, _, test in names:
        found = list((proofs.ROOT / "tests").rglob(file))
        assert found and (not test or f"def {test}(" in found[0].read_text()), (file, test)


def test_every_test_that_names_a_promise_is_of_one_that_is_listed():
    files = (proofs.ROOT / "tests").rglob("test_*.py")
    named = {int(n) for file in files for n in re.findall(r"def test_promise_(\d+)_", file.read_text())}
    assert named <= set(proofs.PROMISES)
