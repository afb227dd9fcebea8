"""A public name is a noun or a verb: no participle that leaves open of what."""

import ast

from tests.environment import ROOT

ROOMS = ("accounts", "operatorlog", "portal", "queueing", "robots", "simulators", "workers")
PARTICIPLES = {"asked", "found", "given", "heard", "kept", "looked", "said", "seen", "shown", "told"}
# Published, on a wire, or in a file that is stored.
FIXED = {"Command.seen", "CommandKind.shown", "Seen", "Setting.shown", "conform.told", "conform_installed.told"}


def names(body, owner=""):
    """Yield the public names that a module or a class defines: functions with their parameters, classes, fields."""
    for node in body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield f"{owner}{node.name}"
            if isinstance(node, ast.ClassDef):
                yield from names(node.body, f"{node.name}.")
            elif not node.name.startswith("_") or node.name == "__init__":
                yield from (f"{node.name}.{one.arg}" for one in (*node.args.args, *node.args.kwonlyargs))
                stored = (one for one in ast.walk(node) if isinstance(one, ast.Attribute))
                yield from (f"{owner}{one.attr}" for one in stored if isinstance(one.ctx, ast.Store))
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            yield f"{owner}{node.target.id}"


def test_no_public_name_is_a_bare_participle():
    found = {}
    for file in (file for room in ROOMS for file in (ROOT / room).rglob("*.py") if "migrations" not in file.parts):
        defined = [file.stem, *names(ast.parse(file.read_text()).body)]
        if bare := {name for name in defined if name.rpartition(".")[2].lower() in PARTICIPLES} - FIXED:
            found[str(file.relative_to(ROOT))] = bare
    assert found == {}
