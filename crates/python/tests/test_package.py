"""The package as its users find it: types, words, documentation."""

import ast
import importlib.metadata
import inspect
import pathlib
import re
import runpy
import shlex
import shutil
import subprocess
import sys

import pytest

import sheer
from sheer import _sheer, metrics

ROOT = pathlib.Path(__file__).parents[3]
PACKAGE = pathlib.Path(sheer.__file__).parent


def model(folder):
    """Puts a model where the pages have theirs."""
    shutil.copy(ROOT / "assets" / "gltf" / "pirate-meshopt" / "pirate.glb", folder / "model.glb")


def stubs():
    return ast.parse((PACKAGE / "_sheer.pyi").read_text()).body


def parameters(arguments):
    """Names of an ast's parameters, with their defaults as text."""
    positional = [argument.arg for argument in arguments.args if argument.arg not in ("self", "cls")]
    defaults = [None] * (len(positional) - len(arguments.defaults)) + arguments.defaults
    both = [*zip(positional, defaults), *zip([argument.arg for argument in arguments.kwonlyargs], arguments.kw_defaults)]
    return [(name, ast.literal_eval(default) if default is not None else inspect.Parameter.empty) for name, default in both]


def found_parameters(function):
    signature = inspect.signature(function).parameters.values()
    return [(parameter.name, parameter.default) for parameter in signature if parameter.name != "self"]


def test_stubs_are_what_is_there():
    assert (PACKAGE / "py.typed").exists()
    functions = {node.name: node for node in stubs() if isinstance(node, ast.FunctionDef)}
    classes = {node.name: node for node in stubs() if isinstance(node, ast.ClassDef)}
    public = {name for name in dir(_sheer) if not name.startswith("_")}
    assert public == functions.keys() | classes.keys()
    assert public == (set(sheer.__all__) | set(metrics.__all__)) - {"__version__", "metrics"}
    for name, node in functions.items():
        assert found_parameters(getattr(_sheer, name)) == parameters(node.args), name
    for name, node in classes.items():
        kind = getattr(_sheer, name)
        members = {member.name: member for member in node.body if isinstance(member, ast.FunctionDef)}
        there = {member for member in vars(kind) if not member.startswith("__")}
        assert there - {"__doc__"} == {member for member in members if not member.startswith("__")}, name
        for member, stub in members.items():
            if callable(getattr(kind, member, None)) and not member.startswith("__"):
                assert found_parameters(getattr(kind, member)) == parameters(stub.args), f"{name}.{member}"


def test_everything_is_documented():
    public = [getattr(module, name) for module in (sheer, metrics) for name in module.__all__ if name != "__version__"]
    for thing in public:
        assert inspect.getdoc(thing), thing
    for kind in (sheer.Camera, sheer.Scene, sheer.Picture):
        for name, member in vars(kind).items():
            assert name.startswith("_") or inspect.getdoc(member), f"{kind.__name__}.{name}"


def test_defaults_are_those_of_the_command_line(command_line):
    def default(command, option):
        text = re.sub(r"\s+", " ", command_line(f"{command} --help"))
        # What stands between an option and its default is its description.
        return re.search(rf"{option} <.*?\[default: ([^;\]]+)", text).group(1)

    signature = dict(found_parameters(sheer.render))
    assert signature["method"] == default("render", "--method")
    assert signature["aa"] == default("render", "--aa")
    assert "{}x{}".format(*sheer.render("layers:count=1", aa="none").size) == default("render", "--size")
    assert str(signature["frames"]) == default("render", "--frames")
    assert str(int(signature["fps"])) == default("render", "--fps")
    assert signature["background"] == default("render", "--background")


def test_the_version_is_that_of_the_wheel():
    assert sheer.__version__ == importlib.metadata.version("sheer")


def test_the_tour_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(ROOT / "docs" / "python_tour.py"))
    assert [path.name for path in tmp_path.iterdir()] == ["wave.png"]
    said = capsys.readouterr().out
    assert "colour (90, 160, 4) float32" in said and "100352 triangles" in said


def test_the_row_of_the_how_to_runs(tmp_path):
    text = (ROOT / "docs" / "how-to.md").read_text()
    [command] = re.findall(r"`(python -c .*?)` \|$", text, re.MULTILINE)
    model(tmp_path)
    python, *arguments = shlex.split(command)
    assert python == "python"
    done = subprocess.run([sys.executable, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.stdout == "(360, 640, 4)\n", done.stderr


@pytest.mark.filterwarnings("ignore::sheer.SheerWarning")
def test_the_page_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "python.md").read_text(), re.DOTALL)
    assert len(blocks) >= 2
    model(tmp_path)
    names = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    assert (tmp_path / "picture.exr").exists()
