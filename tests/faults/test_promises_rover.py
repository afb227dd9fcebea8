"""Promise 12 of the hall rover, which is driven by velocities as the iRat is; the others run over it with all robots."""

import pytest

from tests.faults.test_promises_velocity import a_picture_is_always_answered

pytestmark = [pytest.mark.timed, pytest.mark.length, pytest.mark.parametrize("which", ["srv1"], indirect=True)]


def test_promise_12_a_picture_is_always_answered(rig, proof, people):
    rig.people["ada"] = rig.made_staff(people["ada"])  # who alone may ask for a picture
    a_picture_is_always_answered(rig, proof)
