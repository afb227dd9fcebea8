from hypothesis import given, settings
from hypothesis import strategies as st

from simulators.mercury.arm import AT_REST_M, Body, Pose


@settings(deadline=None, max_examples=25)
@given(st.floats(-0.24, 0.24), st.floats(0.29, 0.55), st.floats(0, 0.075), st.floats(0.02, 0.6))
def test_a_motion_ends_at_its_target_and_the_swing_dies_away(x, y, z, speed):
    body = Body(Pose(0.0, 0.42, 0.075, 0.0), 0.0)
    body.start(Pose(x, y, z, 0.0), speed)
    t = 0.0
    while body.moving and t < 60:
        t += 0.05
        body.advance_to(t)
    assert not body.moving
    assert max(abs(a - b) for a, b in zip(body.setpoint.as_tuple(), (x, y, z, 0.0), strict=True)) < 1e-9
    for i in range(30):
        body.advance_to(t + 0.1 * i)
    assert body.amplitude() < AT_REST_M


def braked(after_s):
    """Return a body that has come to rest by a hold, so many seconds after its motion began."""
    body = Body(Pose(-0.2, 0.42, 0.0, 0.0), 0.0)
    body.start(Pose(0.2, 0.42, 0.0, 0.0), 0.25)
    body.advance_to(after_s)
    body.brake()
    body.advance_to(after_s + 0.5)
    assert not body.moving
    assert body.last_line is not None
    assert body.last_line.braking
    return body


def test_a_hold_brings_it_to_rest_before_the_target():
    assert -0.2 < braked(0.7).setpoint.x < 0.0


def test_a_hold_before_the_first_step_ends_the_motion_where_it_began():
    assert braked(0.0).setpoint == Pose(-0.2, 0.42, 0.0, 0.0)
