"""Docstrings and signatures for the compiled core: mypyc leaves the first out, and writes few of the second.

``setup.py`` calls this on the C files that mypyc has written, before they are compiled. Classes, methods, functions,
properties and fields get the docstrings of their sources, and the signatures as they stand there; an entry without a
source keeps mypyc's own text.
"""

import ast
import re
from functools import lru_cache
from inspect import cleandoc
from itertools import pairwise
from pathlib import Path

SEPARATOR = "\n--\n\n"
"""Ends the signature in the text of a C function; what follows is its docstring (``inspect`` reads both)."""

MODULE = re.compile(r'PyModuleDef_HEAD_INIT,\s*"([\w.]+)"')
TABLE = re.compile(r"static (?:PyMethodDef|PyGetSetDef|PyTypeObject) (\w+)(?:\[\])? = \{")
ENTRY = re.compile(r'\{"(\w+)",')
TEXT = re.compile(r'PyDoc_STR\((?:NULL|"(?:[^"\\]|\\.)*")\)')


def add_docstrings(path):
    """Add docstrings and signatures to one C file of mypyc."""
    code = path.read_text(encoding="utf-8")
    module = MODULE.search(code)
    if module is not None and tree_of(module[1]) is not None:
        lines = with_docstrings(code.splitlines(), module[1])
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def with_docstrings(lines, module):
    """The lines of the C of a module with docstrings in its tables of functions, fields and classes."""
    names = [one.name for one in tree_of(module).body if isinstance(one, ast.ClassDef)]
    class_name, entry, found = None, "", []
    for line in lines:
        table = TABLE.search(line)
        if table is not None:
            class_name = next(
                (one for one in names if f"___{one}_" in f"___{table[1]}_" and is_of(table[1], one)), None
            )
            entry = ""
        named = ENTRY.search(line)
        entry = entry if named is None else named[1]
        found.append(with_docstring(line, module, class_name, entry))
    return found


def is_of(table, class_name):
    """Whether a table of C belongs to the class."""
    return re.search(rf"(?:^|___){class_name}_(?:methods|getseters|template_)$", table) is not None


def with_docstring(line, module, class_name, entry):
    """One line with its docstring, the same line where it holds none."""
    text = None
    if ".tp_doc =" in line:
        text = text_of_class(module, class_name)
    elif "PyDoc_STR" in line:
        text = text_of_function(module, class_name, entry)
    elif line.strip().startswith("NULL, NULL") and line.rstrip().endswith("},"):
        field = field_text(module, class_name, entry)
        head, _, tail = line.rpartition("NULL, NULL")
        return f"{head}PyDoc_STR({c_string(field)}), NULL{tail}" if field else line
    elif "NULL, /* docstring */" in line:
        return line.replace("NULL,", f"PyDoc_STR({c_string(docstring(tree_of(module)))}),")
    return line if text is None else TEXT.sub(lambda _: f"PyDoc_STR({c_string(text)})", line)


def text_of_function(module, class_name, name):
    """Signature and docstring of a function or method, None without a source."""
    node = definition(module, class_name, name)
    return None if node is None else signature(name, node.args) + SEPARATOR + docstring(node)


def text_of_class(module, name):
    """Signature and docstring of a class, None without a source."""
    node = definition(module, None, name)
    if node is None:
        return None
    init = definition(module, name, "__init__")
    return ("" if init is None else signature(name, init.args, bound=True) + SEPARATOR) + docstring(node)


def field_text(module, class_name, name):
    """The docstring of a property, or the text below the assignment of a field."""
    node = definition(module, class_name, name)
    if node is not None:
        return docstring(node)
    owner = definition(module, None, class_name)
    init = definition(module, class_name, "__init__")
    body = [*getattr(owner, "body", []), *getattr(init, "body", [])]
    for statement, following in pairwise(body):
        target = getattr(statement, "target", None)
        is_text = isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant)
        if is_text and name in {getattr(target, "attr", None), getattr(target, "id", None)}:
            return cleandoc(str(following.value.value))
    return ""


@lru_cache(maxsize=1)
def tree_of(module):
    """The source of a module of this package, None for any other."""
    path = Path(*module.split(".")).with_suffix(".py")
    return ast.parse(path.read_text(encoding="utf-8")) if path.is_file() else None


def definition(module, class_name, name):
    """The class or function of that name in a module, or in a class of it."""
    body = getattr(tree_of(module), "body", [])
    for container in (class_name, name) if class_name else (name,):
        kinds = ast.ClassDef | ast.FunctionDef
        node = next((one for one in body if isinstance(one, kinds) and one.name == container), None)
        body = [] if node is None else node.body
    return node


def docstring(node):
    """Its docstring without indentation, "" without one."""
    return cleandoc(ast.get_docstring(node, clean=False) or "")


def signature(name, arguments, bound=False):
    """The signature as ``inspect`` reads it: no annotations, and a mark on the instance."""
    plain = ast.parse(f"def f({ast.unparse(arguments)}): pass").body[0].args
    for one in [*plain.posonlyargs, *plain.args, *plain.kwonlyargs]:
        one.annotation = None
    plain.defaults = [readable(one) for one in plain.defaults]
    plain.kw_defaults = [None if one is None else readable(one) for one in plain.kw_defaults]
    listed = ast.unparse(plain)
    first, comma, rest = listed.partition(", ")
    if first != "self":
        return f"{name}({listed})"
    return f"{name}({rest})" if bound else f"{name}($self{comma}{rest})"


def readable(default):
    """The default, or ... for one that ``inspect`` refuses: it knows constants, and names whose value is one."""
    named = isinstance(default, ast.Name) and default.id not in {"nan", "inf"}
    return ast.Constant(...) if named or isinstance(default, ast.Call) else default


def c_string(text):
    """The text as a string of C."""
    from mypyc.codegen.cstring import c_string_initializer

    return c_string_initializer(text.encode())
