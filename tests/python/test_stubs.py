"""The type stubs match the package, and every public name has a docstring."""

import ast
import inspect
from pathlib import Path

import pytest

import oncollide
import oncollide.trimesh

FOLDER = Path(oncollide.__file__).parent


def parameters(node):
    """Names of a stub's parameters, without self, and whether each has a default."""
    args = node.args
    positional = args.posonlyargs + args.args
    defaults = [False] * (len(positional) - len(args.defaults)) + [True] * len(args.defaults)
    return [(a.arg, d) for a, d in zip(positional, defaults) if a.arg != "self"]


def stubs(module):
    """(qualified name, stub, object) of all functions, methods and properties."""
    tree = ast.parse((FOLDER / (module.__name__.partition(".")[2] or "__init__")).with_suffix(".pyi").read_text())
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, node, getattr(module, node.name)
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            of = getattr(module, node.name)
            for member in node.body:
                if isinstance(member, ast.FunctionDef):
                    yield f"{node.name}.{member.name}", member, getattr(of, member.name)


@pytest.mark.parametrize("module", [oncollide, oncollide.trimesh], ids=lambda m: m.__name__)
def test_stubs_and_runtime_agree(module):
    seen = set()
    for name, stub, real in stubs(module):
        seen.add(name)
        if isinstance(real, property) or any(getattr(d, "id", "") == "property" for d in stub.decorator_list):
            assert isinstance(real, property) or not callable(real), name
            continue
        if name.endswith("__init__"):
            continue  # settings are compared with the runtime below
        signature = inspect.signature(real)
        found = [
            (p.name, p.default is not p.empty)
            for p in signature.parameters.values()
            if p.name != "self" and p.kind is not p.VAR_KEYWORD
        ]
        assert found == parameters(stub), name
    tree = ast.parse((FOLDER / (module.__name__.partition(".")[2] or "__init__")).with_suffix(".pyi").read_text())
    classes = {node.name for node in tree.body if isinstance(node, ast.ClassDef)}
    for name in module.__all__:
        item = getattr(module, name)
        if inspect.ismodule(item):
            continue
        assert name in classes or name in seen, f"{name} has no stub"
        assert inspect.getdoc(item), name
        if inspect.isclass(item) and not issubclass(item, (int, Exception)):
            for member, value in vars(item).items():
                if not member.startswith("_"):
                    assert inspect.getdoc(value), f"{name}.{member} has no docstring"
                    if module is oncollide:
                        assert f"{name}.{member}" in seen, f"{name}.{member} has no stub"


def test_the_settings_of_the_stubs_are_those_that_are_taken():
    tree = ast.parse((FOLDER / "__init__.pyi").read_text())
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and node.name == "World":
            init = next(m for m in node.body if isinstance(m, ast.FunctionDef) and m.name == "__init__")
            names = [a.arg for a in init.args.kwonlyargs]
            with pytest.raises(TypeError) as caught:
                oncollide.World(nothing=1)
            assert names == str(caught.value).partition("valid: ")[2].split(", ")
            for arg, default in zip(init.args.kwonlyargs, init.args.kw_defaults):
                value = ast.literal_eval(default)
                settings = {} if value is None else {arg.arg: value}
                oncollide.World(**settings)


def test_a_program_can_read_the_signatures():
    assert str(inspect.signature(oncollide.mesh)) == "(vertices, faces, name='')"
    assert str(inspect.signature(oncollide.Bodies.set_pose)) == "(self, body, pose)"
    assert str(inspect.signature(oncollide.World().bodies.set_pose)) == "(body, pose)"
    assert (FOLDER / "py.typed").exists()
