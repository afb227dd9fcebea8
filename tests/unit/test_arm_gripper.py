"""What the museum arm's gripper reports of itself."""

import numpy as np

from simulators.pa10.plant import Plant


def test_a_closed_gripper_reports_no_negative_opening():
    plant = Plant()
    rest = np.zeros(6)
    seen = []
    for _ in range(500):  # a second: the fingers press on each other
        plant.step(rest, 1)
        seen.append(plant.measured().opening)
    assert min(seen) >= 0.0
    assert seen[-1] < 0.001
    assert f"{seen[-1]:.2f}" == "0.00"
