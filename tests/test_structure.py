"""The measure of functions: seven arguments and forty lines, but for constructors of records and command lines.

Ruff counts arguments too, and cannot leave out constructors.
"""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "attest_mav"
MAX_ARGUMENTS = 7
MAX_LINES = 40


def functions(text):
    """The functions of a module that are measured."""
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) or node.name == "__init__":
            continue
        if not any(ast.unparse(decorator).startswith("click.") for decorator in node.decorator_list):
            yield node


def arguments(function):
    """How many it has, without self."""
    every = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    return len([one for one in every if one.arg not in {"self", "cls"}])


def violations(text):
    return [
        function.name
        for function in functions(text)
        if arguments(function) > MAX_ARGUMENTS or function.end_lineno - function.lineno >= MAX_LINES
    ]


@pytest.mark.parametrize("module", sorted(PACKAGE.rglob("*.py")), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_functions_are_short_and_have_few_arguments(module):
    assert violations(module.read_text(encoding="utf-8")) == []


def test_the_measure_finds_what_is_too_much():
    many = "def f(a, b, c, d, e, f, g, *, h): pass\n"
    few = "class C:\n    def m(self, a, b, c, d, e, f, g): pass\n    def __init__(self, a, b, c, d, e, f, g, h): pass\n"
    long = "def g():\n" + "    x = 1\n" * 40
    command = "@click.command('x')\ndef c(a, b, c, d, e, f, g, h): pass\n"
    assert violations(many + few + long + command) == ["f", "g"]
