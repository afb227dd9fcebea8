"""Which tests are marked with which requirement of the OWASP Application Security Verification Standard (ASVS) 5.0.

A test says so with ``@pytest.mark.asvs("6.3.1", ...)``, a whole file with ``pytestmark``. The files are
read, not run.
"""

import ast
import tomllib
from collections import defaultdict
from functools import cache
from pathlib import Path

TESTS = Path(__file__).resolve().parent.parent
REQUIREMENTS = Path(__file__).resolve().parent / "requirements.toml"


def requirements() -> dict:
    """Return the requirements of levels 1 and 2: those that apply, and why the others do not."""
    read = tomllib.loads(REQUIREMENTS.read_text())
    return read | {"levels": {number: int(level) for level, numbers in read["levels"].items() for number in numbers}}


@cache
def marked(folder: Path = TESTS) -> dict[str, list[str]]:
    """Return the ids of the tests of each requirement number."""
    found: dict[str, list[str]] = defaultdict(list)
    for path in sorted(folder.rglob("test_*.py")):
        tree = ast.parse(path.read_text())
        name = path.relative_to(TESTS.parent).as_posix()
        everywhere = [n for node in tree.body if _is_pytestmark(node) for n in _numbers(node.value)]
        for test, node in functions_of(tree):
            own = [n for mark in node.decorator_list for n in _numbers(mark)]
            for number in dict.fromkeys([*everywhere, *own]):
                found[number].append(f"{name}::{test}")
    return dict(found)


def functions_of(tree: ast.Module) -> list[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    """Return the tests of a file, those in classes too, by their names."""
    found = []
    for node in tree.body:
        inside = node.body if isinstance(node, ast.ClassDef) else [node]
        before = f"{node.name}::" if isinstance(node, ast.ClassDef) else ""
        for one in inside:
            if isinstance(one, ast.FunctionDef | ast.AsyncFunctionDef) and one.name.startswith("test_"):
                found.append((before + one.name, one))
    return found


def _is_pytestmark(node: ast.stmt) -> bool:
    return isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "pytestmark" for t in node.targets)


def _numbers(node: ast.expr) -> list[str]:
    """Return the numbers in each `pytest.mark.asvs(...)` of an expression."""
    calls = [n for n in ast.walk(node) if isinstance(n, ast.Call) and getattr(n.func, "attr", "") == "asvs"]
    return [a.value for call in calls for a in call.args if isinstance(a, ast.Constant)]
