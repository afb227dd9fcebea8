"""Ranges in words."""

import pytest

from robots.kit.contract.errors import BadRequest
from robots.kit.contract.ranges import from_to, plain, readable
from robots.kit.contract.spec import Argument, CommandKind
from robots.kit.contract.values import within


@pytest.mark.parametrize(
    ("low", "high", "unit", "words"),
    [(0.5, 3.0, "m", "0.5 to 3 m"), (1, 2**24, "", "1 to 16777216"), (-1e-7, 1e300, "m/s", "-1e-07 to 1e+300 m/s")],
)
def test_a_range_is_written_without_exponents_where_it_can_be(low, high, unit, words):
    assert from_to(low, high, unit) == words == Argument("x", unit, low, high).bounds


def test_a_bound_survives_a_field_of_a_form():
    for bound in (0.1, 1 / 3, 16777215.0, -100.25):
        assert float(plain(bound)) == pytest.approx(bound, rel=1e-11)


@pytest.mark.parametrize(
    ("number", "words"),
    [(float("inf"), "inf"), (float("-inf"), "-inf"), (float("nan"), "nan"), (1e308, "1e+308"), (2, "2"), (2.0, "2"),
     (0.123456, "0.1235"), (1234.56, "1235")],
)  # fmt: skip
def test_every_number_is_readable_even_one_that_is_none(number, words):
    assert readable(number) == words


@pytest.mark.parametrize(("value", "refused"), [(1, False), (2.0, False), (1.5, True), (1 + 1e-9, True)])
def test_a_whole_number_has_no_fraction(value, refused):
    kind = CommandKind("go", "Go", (Argument("place", "", 1, 9, whole=True), Argument("x", "m", 0, 9)))
    if refused:
        with pytest.raises(BadRequest, match=r"^place must be a whole number\.$"):
            within(kind, {"place": value, "x": 0.5})
    else:
        within(kind, {"place": value, "x": 0.5})


@pytest.mark.parametrize(("value", "words"), [(5.164e-09, "0"), (-4e-7, "0"), (1e-6, "1e-06"), (0.0123456, "0.01235")])
def test_the_rest_of_a_calculation_reads_as_nothing(value, words):
    assert readable(value) == words
