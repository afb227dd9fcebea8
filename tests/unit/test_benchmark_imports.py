"""The names that a benchmark imports from the portal exist, also those that it imports only while it runs."""

import ast
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

BENCHMARKS = sorted((Path(__file__).resolve().parents[2] / "benchmarks").glob("*.py"))
OURS = {"accounts", "benchmarks", "operatorlog", "portal", "queueing", "robots", "simulators", "tests", "workers"}


@pytest.mark.parametrize("path", BENCHMARKS, ids=lambda path: path.stem)
def test_every_name_that_a_benchmark_imports_exists(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.ImportFrom) or (node.module or "").split(".")[0] not in OURS:
            continue
        if node.module.startswith("benchmarks."):  # one may need an environment of its own
            assert find_spec(node.module), node.module
            continue
        module = import_module(node.module)
        for name in (alias.name for alias in node.names):
            assert hasattr(module, name) or find_spec(f"{node.module}.{name}"), f"{node.module}.{name}"
