"""Which tests may read the machine's clock: those that are timed, so no test of the gate compares measured seconds.

Ruff refuses a clock to every file of tests but those that say that they read one. A test of such a file is timed, and
no other file takes anything from it.
"""

import re
from pathlib import Path
from types import ModuleType
from typing import Any

SAYS_SO = re.compile(r"# (ruff: )?noqa: .*TID251")


def reads_a_clock(module: ModuleType) -> bool:
    """Tell whether Ruff lets a file of tests read a clock."""
    return bool(SAYS_SO.search(Path(str(module.__file__)).read_text()))


def in_the_gate(items: list[Any]) -> list[str]:
    """Return the tests that are not timed, and in a file that reads a clock or takes something from such a file."""
    modules = {item.module for item in items}
    readers = {module.__name__ for module in modules if reads_a_clock(module)}
    takers = {m.__name__ for m in modules for part in vars(m).values() if getattr(part, "__module__", "") in readers}
    return [
        item.nodeid
        for item in items
        if item.module.__name__ in readers | takers and not item.get_closest_marker("timed")
    ]
