"""The list of promises and the tests that name them agree."""

import re

import pytest

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


def record(test, database="sqlite", full=True):
    promise = int(re.search(r"promise_(\d+)", test)[1])
    return {"promise": promise, "test": test, "database": database, "full": full, "counts": []}


def test_what_is_missing_is_told_by_test_robot_and_database():
    wanted = {
        "tests/faults/test_a.py::test_promise_07_stops[mercury]": 7,
        "tests/faults/test_a.py::test_promise_07_stops[irat]": 7,
        "tests/faults/test_b.py::test_promise_45_fuzz[1]": 45,
        "tests/faults/test_c.py::test_promise_45_nobody_notices": 45,
    }
    seven, irat, fuzz, crowd = wanted
    results = [
        record("test_a.py::test_promise_07_stops[mercury]"),
        record("test_b.py::test_promise_45_fuzz[1]"),
        record("test_a.py::test_promise_07_stops[irat]", full=False),
    ]
    assert proofs.missing(wanted, results, "") == {
        (7, "sqlite"): [irat], (7, "postgres"): [seven, irat], (45, "sqlite"): [crowd],
    }  # fmt: skip
    assert proofs.missing(wanted, results, "irat") == {
        (7, "sqlite"): [irat], (7, "postgres"): [irat], (45, "sqlite"): [crowd],
    }  # fmt: skip
    assert proofs.missing({fuzz: 45}, results, "") == {}


@pytest.mark.length
def test_every_test_with_a_proof_is_looked_for():
    """By default each runs until it has run in full, whatever its promise's number."""
    found = proofs.with_proofs()
    assert {28, 29, 30, 31, 32, 45, 49} <= set(found.values())
    assert any("nobody_notices_900" in test for test in found)
    assert any("[irat]" in test for test in found)
    assert found["tests/services/test_motion_machine.py::TestMotion::test_promise_08_anything_in_any_order"] == 8
