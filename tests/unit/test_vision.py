import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.contract.errors import CameraFault
from robots.kit.drivers.mercury.brightness import GAIN_HIGH, GAIN_LOW, STEP, Brightness
from robots.kit.drivers.mercury.calibration import NotCalibrated, Shift, entry, find_change, fit, measure_shift, target
from robots.kit.vision.stability import difference, settle
from simulators.mercury.camera import expose
from tests.unit.sand_beds import fresh

RNG = np.random.default_rng(5)


@pytest.fixture(scope="module")
def bed():
    return fresh(3)


@pytest.fixture(scope="module")
def dug():
    """Sand with three things laid bare."""
    bed = fresh(4)
    for x, y in ((5, 420), (-150, 470), (110, 350)):
        for _ in range(7):
            for dx, dy in ((-8, 7), (8, 7), (8, -7), (-8, -7)):
                bed.blow(x + dx, y + dy, 0.15)
    return bed


def shot(bed, x, y, z=0.0, exposure=1 / 64):
    return expose(bed, [(x, y, z, 0.0)], exposure, RNG)


def test_two_pictures_of_the_same_place_are_stable(bed):
    verdict = settle(lambda: shot(bed, 0.0, 0.42), 0.9)
    assert (verdict.stable, verdict.tries) == (True, 1)


def test_a_swinging_arm_is_unstable_until_it_rests(dug):
    places = iter([0.003, 0.0, 0.002, 0.0, 0.0, 0.0, 0.0])
    verdict = settle(lambda: shot(dug, next(places), 0.42), 0.9)
    assert verdict.stable
    assert verdict.tries == 3


def test_five_tries_then_the_newest_and_an_honest_flag(dug):
    count = iter(range(100))
    verdict = settle(lambda: shot(dug, 0.003 * (next(count) % 2), 0.42), 0.9)
    assert (verdict.stable, verdict.reason, verdict.tries) == (False, "unstable", 5)
    assert next(count) == 10


def test_a_frozen_camera_is_never_stable(bed):
    same = shot(bed, 0.0, 0.42)
    verdict = settle(lambda: same, 0.9)
    assert (verdict.stable, verdict.reason) == (False, "frozen")


def test_a_black_camera_is_never_stable():
    noise = (RNG.integers(0, 2, (165, 192)).astype(np.uint8) for _ in range(20))
    assert settle(lambda: next(noise), 0.9).reason == "black"


def test_a_camera_that_dies_on_the_way_gives_the_newest_picture(dug):
    pictures = iter([shot(dug, 0.0, 0.42), shot(dug, 0.004, 0.42)])

    def grab():
        try:
            return next(pictures)
        except StopIteration:
            raise CameraFault("gone") from None

    assert settle(grab, 0.5).reason == "camera stopped"


def test_pictures_of_another_size_differ():
    assert difference(np.zeros((4, 4), np.uint8), np.zeros((5, 4), np.uint8)) == 255.0


def test_brightness_neither_jumps_nor_blacks_out_over_sand_and_things(dug):
    state = Brightness()
    before = None
    shown_before = np.zeros((165, 192), np.uint8)
    path = [(x / 1000, y / 1000) for x, y in zip(np.linspace(-200, 150, 60), np.linspace(520, 340, 60), strict=True)]
    path += [(0.005, 0.42), (0.11, 0.35), (-0.15, 0.47), (0.2, 0.3)]
    for x, y in path:
        raw = shot(dug, x, y, exposure=1 / 150)
        shown, state = state.correct(raw)
        dark_raw = float((raw < 16).mean())
        assert float((shown < 16).mean()) <= dark_raw + 0.01, "an area was blacked out"
        if before is not None:
            gain_before, raw_before = before
            assert abs(state.gain / gain_before - 1) <= STEP + 1e-9
            still = np.abs(raw.astype(float).mean() - raw_before.astype(float).mean())
            jump = abs(shown.astype(float).mean() - shown_before.astype(float).mean())
            assert jump <= GAIN_HIGH * still + 8, "the light jumped"
        before, shown_before = (state.gain, raw), shown


@given(st.integers(0, 255))
def test_brightness_stays_bounded_and_monotonic(level):
    state = Brightness()
    for _ in range(60):
        _, state = state.correct(np.full((8, 8), level, np.uint8))
    assert GAIN_LOW - 1e-9 <= state.gain <= GAIN_HIGH + 1e-9
    ramp = np.arange(256, dtype=np.uint8).reshape(1, 256).repeat(3, 0)
    shown, _ = state.correct(ramp)
    assert (np.diff(shown[1, 20:-20].astype(int)) >= 0).all()


@settings(deadline=None, max_examples=15)
@given(st.floats(-0.012, 0.012), st.floats(-0.012, 0.012), st.sampled_from([0.0, 0.075]))
def test_the_shift_of_the_picture_tells_the_motion(bed, dx, dy, z):
    du, dv, response = measure_shift(shot(bed, 0, 0.42, z), shot(bed, dx, 0.42 + dy, z))
    mm_per_px = (128 + z * 1000) / 262
    assert response > 0.05
    assert abs(np.hypot(du, dv) * mm_per_px - np.hypot(dx, dy) * 1000) < 1.0


@given(st.floats(-0.2, 0.2), st.floats(3e-4, 9e-4), st.floats(-5, 5), st.floats(-5, 5))
def test_fit_finds_an_affine_map_again(turn, scale, nu, nv):
    c, s = np.cos(turn) * scale, np.sin(turn) * scale
    matrix = np.array([[c, s], [s, -c]])
    shifts = []
    for dx, dy in ((0.018, 0), (0, 0.018), (-0.014, 0.014), (0.01, 0.02)):
        du, dv = -np.linalg.solve(matrix, [dx, dy])
        shifts.append(Shift(dx, dy, du, dv))
    found, residual = fit(shifts)
    assert np.allclose(found, matrix, atol=1e-9)
    assert residual < 1e-6
    one = entry(shifts, (nu, nv), 0.0, 0.0)
    x, y = target({"down": one}, (0.1, 0.4, 0.0, 0.0), nu + 95.5, nv + 82, 192, 165)
    assert np.allclose((x, y), (0.1, 0.4), atol=1e-9), "the nozzle's own pixel means no motion"


def test_the_map_turns_with_the_camera():
    one = {"matrix": [[5e-4, 0, 0], [0, -5e-4, 0]], "z": 0.0, "theta": 0.0}
    square = target({"down": one}, (0.0, 0.4, 0.0, 0.0), 105.5, 82, 192, 165)
    turned = target({"down": one}, (0.0, 0.4, 0.0, np.pi / 2), 105.5, 82, 192, 165)
    assert np.allclose(square, (0.005, 0.4))
    assert np.allclose(turned, (0.0, 0.405))


def test_too_few_or_collinear_shifts_are_refused():
    with pytest.raises(NotCalibrated, match="Too few"):
        fit([Shift(0.01, 0, 10, 0)])
    with pytest.raises(NotCalibrated, match="two directions"):
        fit([Shift(0.01, 0, 10, 0), Shift(0.02, 0, 20, 0), Shift(-0.01, 0, -10, 0)])


def test_another_height_is_not_calibrated():
    with pytest.raises(NotCalibrated, match="height"):
        target({"down": {"matrix": [[1, 0, 0], [0, 1, 0]], "z": 0.0, "theta": 0.0}}, (0, 0.4, 0.075, 0), 1, 1, 192, 165)


@pytest.mark.parametrize("place", [(0.0, 0.42), (-0.1, 0.4), (0.1, 0.45), (-0.2, 0.52)])
@pytest.mark.parametrize("z", [0.0, 0.075])
def test_a_burst_shows_where_the_nozzle_is(place, z):
    bed = fresh(int(place[0] * 1000) + 300)
    before = shot(bed, *place, z)
    bed.blow(place[0] * 1000, place[1] * 1000, 0.3)
    u, v = find_change(before, shot(bed, *place, z))
    mm = (128 + z * 1000) / 262
    assert abs(-u * mm - 3.0) < 1.0
    assert abs(v * mm + 2.2) < 1.0


def test_no_mark_no_nozzle(bed):
    with pytest.raises(NotCalibrated, match="no mark"):
        find_change(shot(bed, 0, 0.42), shot(bed, 0, 0.42))
