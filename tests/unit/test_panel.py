import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from robots.kit.description import load
from robots.kit.drivers.mercury.panel import BUTTONS_TOP, HEIGHT, WIDTH, at, compose, press
from robots.kit.drivers.mercury.scara import scara

D = load("mercury")


@given(st.integers(-10, 2 * WIDTH + 10), st.integers(-10, 2 * HEIGHT + 10), st.sampled_from([1, 2]))
def test_every_pixel_means_one_thing_or_nothing(x, y, scale):
    wanted = press(x, y, 7, D, scale)
    inside = 0 <= x < WIDTH * scale and 0 <= y < HEIGHT * scale
    assert (wanted is not None) == inside
    if wanted is None:
        return
    if y / scale >= BUTTONS_TOP:
        assert wanted.kind in ("up", "down", "air", "stop")
    elif x / scale < 192:
        assert wanted.kind == "click"
        assert wanted.args["still"] == 7
        assert 0 <= wanted.args["u"] < 192
    else:
        assert wanted.kind == "move"


@pytest.mark.parametrize(("x", "kind"), [(10, "up"), (100, "down"), (200, "air"), (330, "stop")])
def test_the_buttons_are_where_they_are_drawn(x, kind):
    assert press(x, 180, 0, D).kind == kind


def test_a_click_on_the_drawn_tool_means_where_the_tool_is():
    u, v = at(0.100, 0.450, D)
    wanted = press(round(u), round(v), 0, D)
    assert abs(wanted.args["x"] - 0.100) < 0.005
    assert abs(wanted.args["y"] - 0.450) < 0.005


@pytest.mark.parametrize("greys", [64, 256])
def test_the_panel_is_a_gif_with_that_many_greys(greys):
    q = scara(D).inverse(0.0, 0.42, 0.0, 0.0)
    data = compose(None, D, list(q), greys)
    image = Image.open(io.BytesIO(data))
    assert image.format == "GIF"
    assert image.size == (WIDTH, HEIGHT)
    assert len(image.convert("L").getcolors(256)) <= greys
