"""`make asvs`: write `docs/reference/asvs.md` from the tests' marks and `requirements.toml`."""

import sys

from tests.asvs.marks import TESTS, marked, requirements

PAGE = TESTS.parent / "docs" / "reference" / "asvs.md"
HEAD = """# OWASP ASVS, level 2: what applies

Written by `make asvs` from the marks of the tests (`@pytest.mark.asvs`) and from `tests/asvs/requirements.toml`; do not edit it by hand. The numbers are those of the Application Security Verification Standard 5.0, levels 1 and 2; the words are ours and shorter, so read the standard for what a requirement asks in full. This is our own reading of it, not an assessment by anybody else.

"""


def page() -> str:
    """Return the page."""
    known, tests = requirements(), marked()
    applies = known["applies"]
    tested = [n for n in applies if n in tests]
    gaps = [n for n, one in applies.items() if "gap" in one]
    lines = [
        HEAD + f"{len(known['levels'])} requirements, of which {len(applies)} apply: {len(tested)} have tests, "
        f"{len(gaps)} are not met or not met in full, the rest are met by what is named.\n"
    ]
    chapter = ""
    for number, one in applies.items():
        if number.split(".")[0] != chapter:
            chapter = number.split(".")[0]
            lines.append(
                f"\n## {chapter}. {known['chapters'][chapter]}\n\n| | level | | proven by |\n|---|---|---|---|"
            )
        proof = [f"`{test.removeprefix('tests/')}`" for test in tests.get(number, [])[:4]]
        if len(tests.get(number, [])) > 4:
            proof.append(f"and {len(tests[number]) - 4} more")
        if "where" in one:
            proof.append(one["where"])
        if "gap" in one:
            proof.append(f"**Not met:** {one['gap']}")
        lines.append(f"| {number} | {known['levels'][number]} | {one['words']} | {'<br>'.join(proof)} |")
    lines.append("\n## What does not apply\n\n| | why |\n|---|---|")
    lines += [f"| {number} | {why} |" for number, why in known["absent"].items()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page())
    sys.stdout.write(f"{PAGE.relative_to(TESTS.parent)} is written\n")
