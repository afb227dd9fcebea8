"""The texts that scripts mark are found in their sources."""

import re
from pathlib import Path

import pytest

from tools.translations import of_script

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "frontend/src/kit/text.ts"  # which defines the functions
SCRIPTS = [
    p for p in [*ROOT.glob("frontend/src/**/*.ts"), *ROOT.glob("robots/kit/drivers/*/console/**/*.ts")] if p != MODULE
]
CALL = re.compile(r"(?<![\w.#])n?gettext\(")


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ('gettext("One {n}", { n: "two" })', ["One {n}"]),
        ("const f = new Map<string, number>(); gettext('It\\'s \"two\"');", ['It\'s "two"']),
        (
            'html`<p title=${gettext("In a template")}>${ngettext("one", "many", n)}</p>`',
            ["In a template", ("one", "many")],
        ),
        ('gettext(\n  "Long " +\n    "one.",\n)', ["Long one."]),
        ('gettext("Tab\\t \\u2026")', ["Tab\t …"]),
        ('gettext(name); this.gettext("no"); gettext(`no`); gettext(a ? "b" : "c")', []),
    ],
)
def test_literal_texts_are_found_wherever_typescript_has_them(source, found):
    assert [texts for _, texts, _ in of_script(source)] == found


def test_no_call_is_overlooked():
    sources = {path: path.read_text() for path in SCRIPTS}
    missed = [str(p) for p, source in sources.items() if len(CALL.findall(source)) != len(list(of_script(source)))]
    assert sources
    assert missed == []
