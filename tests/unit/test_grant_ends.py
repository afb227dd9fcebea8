"""Only one function ends a grant; another one would skip parts of the end."""

import ast
import re

from tests.environment import ROOT

ROOMS = ("accounts", "operatorlog", "portal", "queueing", "robots", "workers")
OF_A_GRANT = re.compile(r"\bGrant\.|\.grants\b|\bgrant\.(save|ended_at =)|open_grant\(")
ENDS = {"ended_at", "end_code"}


def writes_an_end(node: ast.AST) -> bool:
    """Tell whether a statement writes `ended_at` or `end_code`, by keyword, attribute or name."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        written = node.func.attr in {"update", "create", "update_or_create", "bulk_update"}
        named = {k.arg for k in node.keywords} | {a.value for a in ast.walk(node) if isinstance(a, ast.Constant)}
        return written and bool(ENDS & named)
    targets = node.targets if isinstance(node, ast.Assign) else []
    return any(isinstance(t, ast.Attribute) and t.attr in ENDS for t in targets)


def enders(source: str) -> list[str]:
    """Return the functions of `source` that write the end of a grant."""
    found = []
    for function in ast.walk(ast.parse(source)):
        if not isinstance(function, ast.FunctionDef):
            continue
        writes = [node for node in ast.walk(function) if writes_an_end(node)]
        if any(OF_A_GRANT.search(ast.unparse(node)) for node in writes):
            found.append(function.name)
    return found


def test_one_function_alone_ends_a_grant():
    found = {
        (str(path.relative_to(ROOT)), name)
        for room in ROOMS
        for path in (ROOT / room).rglob("*.py")
        if "migrations" not in path.parts
        for name in enders(path.read_text())
    }
    assert found == {("robots/grants.py", "end_grant")}


def test_each_way_of_writing_it_is_seen():
    assert enders("def f(g, now):\n    Grant.objects.filter(pk=g.pk).update(ended_at=now)") == ["f"]
    assert enders("def f(robot, now):\n    robot.grants.update(**{'ended_at': now})") == ["f"]
    assert enders("def f(grant, now):\n    grant.ended_at = now\n    grant.save()") == ["f"]
    assert enders("def f(turn, now):\n    Turn.objects.filter(pk=turn.pk).update(ended_at=now)") == []
