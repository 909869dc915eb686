"""The architecture, read from the sources: who imports whom, what is exported, and what importing does."""

import ast
import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

import nephrite
from nephrite import llvm

SOURCE = Path(nephrite.__file__).parent
LAYERS = [
    {"errors"}, {"llvm"}, {"geometry"}, {"physics"}, {"materials"}, {"profiles"}, {"bssrdf"}, {"transport"},
    {"plugins"}, {"scene"},
    {"image"}, {"relighting"}, {"rendering"}, {"atlas"}, {"cli"},
]  # fmt: skip
RANK = {name: rank for rank, layer in enumerate(LAYERS) for name in layer}
REGISTERS = {
    f"register_{kind}" for kind in ("bsdf", "integrator", "emitter", "medium", "shape", "texture", "volume")
}
FILES = sorted(SOURCE.rglob("*.py"))
MODULES = [path for path in FILES if path != SOURCE / "__init__.py"]


def _name(path):
    return str(path.relative_to(SOURCE))


def _imports(tree):
    """Yield the dotted names of everything that a module imports, wherever in the file it does."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _outside_functions(node):
    """Yield the nodes that run on import: all but the bodies of functions, and annotations."""
    for field, value in ast.iter_fields(node):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) and field == "body":
            continue
        if field in ("annotation", "returns"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield child
                yield from _outside_functions(child)


def _uses_mitsuba(node):
    return (
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id in ("mi", "mitsuba")
    )


@pytest.mark.parametrize("path", MODULES, ids=_name)
def test_imports_point_downwards(path):
    layer = path.relative_to(SOURCE).parts[0].removesuffix(".py")
    assert layer in RANK, f"{layer} is in no layer: add it to the list in design and here"
    for imported in _imports(ast.parse(path.read_text())):
        parts = imported.split(".")
        if parts[0] != "nephrite" or parts[1] == "__version__":
            continue
        assert parts[1] in RANK, f"{_name(path)} imports {imported}"
        assert parts[1] == layer or RANK[parts[1]] < RANK[layer], f"{_name(path)} imports {imported}"


@pytest.mark.parametrize("path", [p for p in MODULES if "plugins" not in p.parts], ids=_name)
def test_only_plugins_are_bound_to_a_variant(path):
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            assert not any(_uses_mitsuba(base) for base in node.bases), f"{node.name} derives from Mitsuba's"
        if isinstance(node, ast.Attribute):
            assert node.attr not in REGISTERS, f"{_name(path)} registers a plugin"
        if isinstance(node, ast.ImportFrom):
            assert (node.module or "").split(".")[0] not in ("mitsuba", "drjit"), "names go stale on a switch"
    assert not [ast.unparse(n) for n in _outside_functions(tree) if _uses_mitsuba(n)], "used while importing"


@pytest.mark.parametrize("path", [p for p in MODULES if {"physics", "profiles"} & set(p.parts)], ids=_name)
def test_physics_and_profiles_know_no_mitsuba(path):
    tree = ast.parse(path.read_text())
    assert "mitsuba" not in {name.split(".")[0] for name in _imports(tree)}
    # what is too slow in NumPy loads Dr.Jit when it is called
    loading = ast.Module(
        [n for n in _outside_functions(tree) if isinstance(n, ast.Import | ast.ImportFrom)], []
    )
    assert "drjit" not in {name.split(".")[0] for name in _imports(loading)}


def test_files_are_short():
    long = {_name(path): n for path in FILES if (n := len(path.read_text().splitlines())) > 400}
    assert not long


def test_all_is_what_the_package_exports():
    modules = {path.relative_to(SOURCE).parts[0].removesuffix(".py") for path in MODULES}
    public = {name for name in vars(nephrite) if not name.startswith("_")} - modules - {"annotations"}
    assert public | {"__version__"} == set(nephrite.__all__)


@pytest.mark.parametrize("path", FILES, ids=_name)
def test_each_all_names_what_is_there(path):
    if "plugins" in path.parts:
        return  # imported by the package alone, in a variant
    parts = path.relative_to(SOURCE.parent).with_suffix("").parts
    module = importlib.import_module(".".join(parts).removesuffix(".__init__"))
    names = getattr(module, "__all__", [])
    assert len(names) == len(set(names))
    for name in names:
        assert hasattr(module, name)


def _python(code, **environment):
    """Run code in a fresh interpreter; a script for every order of importing."""
    library = llvm.packaged_library()
    named = {llvm.ENVIRONMENT_VARIABLE: str(library)} if library else {}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env={**os.environ, **named, **environment},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


LOAD = """
mi.load_dict({'type': 'translucent', 'material': 'jade'}); mi.load_dict({'type': 'translucent_path'})
"""


@pytest.mark.parametrize(
    "code",
    [
        "import nephrite, mitsuba as mi\nassert mi.variant() is None, mi.variant()",
        "import mitsuba as mi\nimport nephrite\nassert mi.variant() is None, mi.variant()",
        "import nephrite, mitsuba as mi\nmi.set_variant('llvm_ad_rgb')" + LOAD,
        "import mitsuba as mi\nmi.set_variant('llvm_ad_rgb')\nimport nephrite\nassert mi.variant() == 'llvm_ad_rgb'"
        + LOAD,
        "import mitsuba as mi\nimport nephrite\nmi.set_variant('llvm_ad_mono')" + LOAD,
        "import mitsuba as mi\nmi.set_variant('scalar_rgb')\nimport nephrite\nmi.set_variant('llvm_ad_rgb')"
        + LOAD,
        "import nephrite, mitsuba as mi\nfor v in ('llvm_ad_rgb', 'scalar_rgb', 'llvm_ad_mono', 'llvm_ad_rgb'):\n"
        "    mi.set_variant(v)" + LOAD,
    ],
    ids=["none-set", "none-set-after", "before", "after", "between", "after-scalar", "switched"],
)
def test_importing_works_in_any_order_and_sets_no_variant(code):
    _python(code)


def test_the_packaged_llvm_wins_unless_the_user_names_one(monkeypatch):
    library = llvm.packaged_library()
    if library is None:
        pytest.skip("no packaged LLVM on this platform")
    monkeypatch.delenv(llvm.ENVIRONMENT_VARIABLE, raising=False)
    llvm.prefer_packaged()
    assert os.environ[llvm.ENVIRONMENT_VARIABLE] == str(library)
    monkeypatch.setenv(llvm.ENVIRONMENT_VARIABLE, "/somewhere/libLLVM.so")
    llvm.prefer_packaged()
    assert os.environ[llvm.ENVIRONMENT_VARIABLE] == "/somewhere/libLLVM.so"
