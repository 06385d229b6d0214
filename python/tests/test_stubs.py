"""The stubs say what the compiled module has: the same names, arguments and defaults."""
import ast
import inspect
import pathlib
import re

import foldproof
from foldproof import _core

STUBS = ast.parse((pathlib.Path(foldproof.__file__).parent / "_core.pyi").read_text())


def arguments(function):
    """Names, kinds and defaults of a function's arguments, as a comparable list."""
    a = function.args
    defaults = [None] * (len(a.posonlyargs + a.args) - len(a.defaults)) + a.defaults
    listed = [("positional", x.arg, ast.dump(d) if d else None) for x, d in zip(a.posonlyargs + a.args, defaults)]
    listed += [("rest", "*", None)] * bool(a.vararg)
    listed += [("keyword", x.arg, ast.dump(d) if d else None) for x, d in zip(a.kwonlyargs, a.kw_defaults)]
    return listed + [("rest", "**", None)] * bool(a.kwarg)


def documented(function):
    """The same of a compiled function, by inspect.signature."""
    signature = inspect.signature(function)
    text = str(signature.replace(parameters=[p.replace(annotation=p.empty) for p in signature.parameters.values()]))
    return arguments(ast.parse(f"def f{text}: ...").body[0])


def is_property(node):
    return any(isinstance(d, ast.Name) and d.id == "property" for d in node.decorator_list)


def test_same_names():
    stubbed = {n.name for n in STUBS.body if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
    stubbed |= {n.target.id for n in STUBS.body if isinstance(n, ast.AnnAssign)}
    assert {n for n in stubbed if not re.match("_[A-Z]", n)} == {n for n in vars(_core) if not re.match("_(?!_version)", n)}


def test_same_signatures():
    compared = 0
    for node in STUBS.body:
        if isinstance(node, ast.FunctionDef):
            assert arguments(node) == documented(getattr(_core, node.name)), node.name
            compared += 1
        if not isinstance(node, ast.ClassDef) or node.name.startswith("_"):
            continue
        real = getattr(_core, node.name)
        members = {n.name: n for n in node.body}
        has = {n for n in vars(real) if not n.startswith("_") or n in ("__len__", "__getitem__")}
        assert has == {n for n in members if n not in ("__init__", "__iter__")}, node.name
        for name, member in members.items():
            if name == "__iter__":  # from __getitem__
                continue
            if is_property(member):
                assert isinstance(vars(real)[name], property), f"{node.name}.{name}"
            else:
                assert arguments(member) == documented(getattr(real, name)), f"{node.name}.{name}"
                compared += 1
    assert compared > 20


def test_everything_is_documented():
    for name in foldproof.__all__:
        thing = getattr(foldproof, name)
        if isinstance(thing, type):
            assert thing.__doc__ and thing.__module__ == "foldproof"
            for member, value in vars(thing).items():
                if not member.startswith("_"):
                    assert value.__doc__, f"{name}.{member}"
        elif callable(thing):
            assert thing.__doc__ and not thing.__doc__.startswith(name), name


def test_classes_have_signatures():
    assert str(inspect.signature(foldproof.Motion)) == "(triangles, frames, name='array', *, parts=None)"
    assert list(inspect.signature(foldproof.check).parameters)[:3] == ["motions", "models", "frames"]
    checker = foldproof.ContactChecker(foldproof.CollisionMesh([[0, 0, 0]]))
    assert str(inspect.signature(checker.candidates)) == "(x0, x1=None, *, inflation)"
    assert "settings, all by keyword" in foldproof.check.__doc__
