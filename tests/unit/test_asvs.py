"""The table of security requirements, the page of threats and that of what users expect agree with the tests."""

import ast
import re

import pytest

from tests.asvs.__main__ import PAGE, page
from tests.asvs.marks import TESTS, functions_of, marked, requirements

THREATS = TESTS.parent / "docs" / "explanation" / "threats.md"
UX = TESTS.parent / "docs" / "reference" / "ux.md"
NAMED = re.compile(r"`(tests/[\w/]+\.py)::([\w:]+)`")


def test_each_requirement_has_a_test_a_place_or_a_gap():
    known, tests = requirements(), marked()
    silent = [n for n, one in known["applies"].items() if n not in tests and not {"where", "gap"} & set(one)]
    assert silent == []
    both = [n for n, one in known["applies"].items() if "gap" in one and n in tests and "in full" not in one["gap"]]
    assert both == [], "a requirement with a test is not a gap, or the gap says what is missing in full"


def test_each_number_is_one_of_the_standard_and_stands_once():
    known = requirements()
    applies, absent = set(known["applies"]), set(known["absent"])
    assert set(marked()) <= applies
    assert applies <= set(known["levels"])
    for number in known["levels"]:
        inside = [one for one in absent if number == one or number.startswith(f"{one}.")]
        assert (number in applies) + len(inside) == 1, number


def test_the_table_is_as_the_marks_are():
    assert PAGE.read_text() == page(), "write it anew with `make asvs`"


@pytest.mark.parametrize("page", [THREATS, UX], ids=lambda page: page.stem)
def test_each_row_of_a_page_names_tests_that_exist(page):
    text = page.read_text()
    rows = [line for line in text.splitlines() if line.startswith("|")]
    claims = [row for row in rows if not row.startswith(("| tries |", "| subject |", "|---"))]
    assert claims
    assert [row for row in claims if not NAMED.search(row)] == [], "a row without a test"
    named = set(NAMED.findall(text))
    for file, test in sorted(named):
        path = TESTS.parent / file
        assert path.exists(), file
        assert test in {name for name, _ in functions_of(ast.parse(path.read_text()))}, f"{file}::{test}"
