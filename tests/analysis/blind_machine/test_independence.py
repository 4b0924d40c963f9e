"""The blind machine shares nothing with what it tests: read from its source, not from its word."""

import ast
from importlib.resources import files

import pytest

PACKAGE = "gapscope.analysis.blind_machine"
ALLOWED = {"numpy", "types", "numba", "yaml", "collections", "dataclasses", "pathlib", "typing"}
SOURCES = sorted(p for p in files(PACKAGE).iterdir() if p.name.endswith(".py"))


def imported(tree: ast.AST) -> set[str]:
    """Every absolute module name a file imports, relative imports resolved."""
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            parents = PACKAGE.split(".")[: len(PACKAGE.split(".")) + 1 - node.level]
            names.add(".".join([*(parents if node.level else []), *filter(None, [node.module])]))
    return names


@pytest.mark.parametrize("source", SOURCES, ids=lambda p: p.name)
def test_imports_nothing_of_the_toolbox_but_itself(source):
    outside = {
        name
        for name in imported(ast.parse(source.read_text()))
        if name.split(".")[0] not in ALLOWED and f"{name}.".startswith(f"{PACKAGE}.") is False
    }
    assert outside == set()


@pytest.mark.parametrize("source", SOURCES, ids=lambda p: p.name)
def test_imports_nothing_by_name_at_run_time(source):
    calls = {
        node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
        for node in ast.walk(ast.parse(source.read_text()))
        if isinstance(node, ast.Call)
    }
    assert calls.isdisjoint({"__import__", "import_module", "exec", "eval"})


def test_the_check_sees_a_forbidden_import():
    tree = ast.parse("from ...models.friction import tanh_friction\nfrom ..gap import diagnose")
    assert imported(tree) == {"gapscope.models.friction", "gapscope.analysis.gap"}
