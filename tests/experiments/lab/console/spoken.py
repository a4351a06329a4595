"""Sentences that the console can show, collected from the syntax of the modules that make them.

A sentence is the template of a message, or a whole text. Inserted values are followed to the
constants, variables and functions that they come from, as far as names tell.
"""

import ast
import re
from functools import cache
from importlib.metadata import distribution
from pathlib import Path

import slipscale
from slipscale.hardware.errors import FAULTS

ROOT = Path(slipscale.__path__[0])
PACKAGES = ("analysis", "experiments", "faults", "hardware", "stimuli")
IMPORTS = re.compile(r"(?:from|import) (slipscale[\w.]+)|\"(slipscale\.[\w.]+)[:\"]")
SENTENCE = re.compile("[a-z]{3},? [a-z(]|[a-z] [a-z]{3}")  # two words at least
# Classes of errors that are also returned, and a function that raises its arguments.
TELLERS = {
    "UserError",
    "RigError",
    "differs",
    "_refused",
    *(kind.__name__ for kind in FAULTS.values()),
}
TELLING = re.compile(
    rf"\braise |\"msg\":|_refused\(|\b({'|'.join(TELLERS)})\(|\b(remedy|detail|what|problem)="
)
# Errors that users never see: the calling code catches them, or they are defects.
INTERNAL = {"ArgumentError", "AttributeError", "HTTPException", "LookupError", "RuntimeError"}
INTERNAL |= {"SystemExit", "TypeError"}


@cache
def sources():
    """Return the path of every module by name."""
    found = {}
    for package in PACKAGES:
        folder = (ROOT / package).resolve()
        for path in folder.rglob("*.py"):
            parts = path.relative_to(folder).with_suffix("").parts
            found[".".join(("slipscale", package, *parts)).removesuffix(".__init__")] = path
    return found


@cache
def text_of(name):
    return sources()[name].read_text(encoding="utf-8")


def reached_from(names):
    """Return the modules that some modules and our plug-ins import, at any depth."""
    plug_ins = [each.module for each in distribution("slipscale").entry_points]
    found, todo = set(), [*names, *plug_ins]
    while todo:
        name = todo.pop()
        if name in sources() and name not in found:
            found.add(name)
            todo += (each for both in IMPORTS.findall(text_of(name)) for each in both)
            todo += (f"{origin}.{word}" for word, origin in origins_in(name).items())
    return found


@cache
def syntax(name):
    return ast.parse(text_of(name))


@cache
def functions_in(name):
    """Return a module's functions and its classes' methods."""
    bodies = [syntax(name).body]
    bodies += [each.body for each in syntax(name).body if isinstance(each, ast.ClassDef)]
    return [each for body in bodies for each in body if isinstance(each, ast.FunctionDef)]


@cache
def known_in(name):
    """Return a module's constants and functions by name."""
    return assigned(syntax(name).body) | {each.name: each for each in functions_in(name)}


@cache
def origins_in(name):
    """Return the module that each imported name comes from."""
    found = re.findall(r"from (slipscale\S+) import (\([^)]*|.*)", text_of(name))
    return {word: origin for origin, words in found for word in re.findall(r"\w+", words)}


def assigned(nodes):
    found = {}
    for node in nodes:
        if isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign) and node.value:
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            found.setdefault(ast.unparse(target), []).append(node.value)
    return found


@cache
def local_in(function):
    return assigned(ast.walk(function))


def told(node, *, everything):  # noqa: PLR0911 - a rule per return
    """Return the expressions that a node raises or, on request, returns or shows otherwise."""
    match node:
        case ast.Raise(exc=ast.Call(func=kind, args=arguments, keywords=given)):
            word = ast.unparse(kind)
            told_by = [*arguments, *(each.value for each in given)]
            return [] if word in INTERNAL else told_by if word[0].isupper() else [node.exc]
        case ast.Call(func=ast.Name(word), args=arguments, keywords=given) if word in TELLERS:
            return [*arguments, *(each.value for each in given)]
        case ast.keyword(arg="remedy" | "detail" | "what" | "problem", value=value):
            return [value]
        case ast.Dict(keys=keys, values=values):  # a fault of a file
            return [v for k, v in zip(keys, values, strict=True) if ast.unparse(k or v) == "'msg'"]
        case ast.Return(value=value) | ast.Yield(value=value) if everything and value:
            return [value]
        case ast.Call(func=ast.Attribute(attr="start" | "say"), args=arguments) if everything:
            return arguments
    return []


def chosen_from(node):
    """Return the parts of an expression that can be its value."""
    match node:
        case ast.IfExp(body=first, orelse=second):
            return [first, second]
        case ast.Dict(values=values):
            return values
        case ast.Subscript(value=value):
            return [value]
        case ast.Compare():
            return []
        case ast.Call(func=function) if re.match(r"[A-Z]\w*$|re\.", ast.unparse(function)):
            return []
    return ast.iter_child_nodes(node)


class Sentences:
    """The sentences of a module: its errors or, on request, all that it shows."""

    def __init__(self, name, *, everything=False):
        self.found = set()
        self._followed = set()
        if not everything and not TELLING.search(text_of(name)):
            return
        lines = text_of(name).splitlines()
        for function in functions_in(name):
            own = "\n".join(lines[function.lineno - 1 : function.end_lineno])
            for node in ast.walk(function) if everything or TELLING.search(own) else ():
                for each in told(node, everything=everything):
                    self._keep(each, (name, function))

    def _keep(self, node, scope):
        texts = (text.removeprefix("; ") for text in self._texts(node, scope))
        # A text that ends in a colon is the beginning of one.
        self.found.update(t for t in texts if SENTENCE.search(t) and not t.endswith(": "))

    def _texts(self, node, scope):
        """Return the texts that an expression can have; keep those of its inserted values."""
        match node:
            case ast.Constant(value=str(text)):
                return [text]
            case ast.Call(func=ast.Name("Message"), args=[template], keywords=given):
                for each in given:
                    self._keep(each.value, scope)
                return self._texts(template, scope)
            case ast.JoinedStr(values=parts):
                for part in parts:
                    if isinstance(part, ast.FormattedValue):
                        self._keep(part.value, scope)
                return ["".join(p.value if isinstance(p, ast.Constant) else "{}" for p in parts)]
            case ast.BinOp(op=ast.Add(), left=left, right=right):
                lasts = self._texts(right, scope) or ["{}"]
                return [a + b for a in self._texts(left, scope) or ["{}"] for b in lasts]
            case ast.Name(id=word) | ast.Attribute(value=ast.Name("self"), attr=word):
                return self._named(word, scope)
        return [text for each in chosen_from(node) for text in self._texts(each, scope)]

    def _named(self, word, scope):
        """Return the texts of a variable, of a constant, or of what a function returns."""
        name, function = scope
        local = local_in(function).get(word) if function else None
        meant = local or known_in(name).get(word)
        if not local:
            function = None
        if not meant and (name := origins_in(name).get(word)) in sources():
            meant = known_in(name).get(word)
        if not meant or (name, word, function) in self._followed:
            return []
        self._followed.add((name, word, function))
        if isinstance(meant, ast.FunctionDef):
            function = meant
            ends = (n for n in ast.walk(meant) if isinstance(n, ast.Return | ast.Yield))
            meant = [each.value for each in ends if each.value]
        return [text for each in meant for text in self._texts(each, (name, function))]
