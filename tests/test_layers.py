"""Who may import whom: the layers of the design, read from the sources."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = "meshlab_symrecon"

BORDER = {"errors", "arrays", "one_thread", "provenance"}
KERNEL = BORDER | {"_native", "geometry"}
ALGORITHMS = {"clustering", "symmetry", "powercrust"}
ALLOWED = {
    "errors": set(),
    "arrays": {"errors"},
    "one_thread": set(),
    "provenance": {"arrays"},
    "geometry": BORDER | {"_native"},
    "clustering": KERNEL,
    "symmetry": KERNEL | {"clustering"},
    "powercrust": KERNEL | {"clustering"},
    "plugin": BORDER,
    "filters": KERNEL | ALGORITHMS | {"plugin"},
    "host": BORDER | {"_native", "plugin"},  # _native: the standard streams only
    "pictures": BORDER,
    "batch": BORDER | {"plugin", "host"},
    "cli": BORDER | {"plugin", "host", "pictures", "batch"},
    "__main__": {"cli"},
    "": {"errors", "host", "plugin"},  # the package itself, lazily
}


def modules():
    """Return the name of each module, and its path."""
    found = {}
    for folder, prefix in ((ROOT / PACKAGE, (PACKAGE,)), (ROOT / "filters", (PACKAGE, "filters"))):
        for path in sorted(folder.rglob("*.py")):
            parts = (*prefix, *path.relative_to(folder).with_suffix("").parts)
            found[".".join(parts).removesuffix(".__init__")] = path
    return found


MODULES = modules()


def imports(path):
    """Return each imported module, in full, and its line; relative ones begin with a dot."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = "." * node.level + (node.module or "")
            yield base, node.lineno
            if base == PACKAGE:  # from meshlab_symrecon import geometry
                yield from ((f"{base}.{alias.name}", node.lineno) for alias in node.names)


def part(module):
    """Return the layer of a module of ours: the name after the package's."""
    return [*module.split("."), ""][1]


def test_every_layer_is_in_the_table():
    assert {part(module) for module in MODULES} <= set(ALLOWED)


@pytest.mark.parametrize("module", MODULES)
def test_imports_stay_within_the_layers(module):
    allowed = ALLOWED[part(module)] | {part(module), ""}
    for name, line in imports(MODULES[module]):
        assert not name.startswith("."), f"{module}:{line} imports relatively: {name}"
        if name.split(".")[0] == PACKAGE and name != f"{PACKAGE}.__version__":
            assert part(name) in allowed, f"{module}:{line} must not import {name}"
        else:
            assert name.split(".")[0] != "filters", f"{module}:{line}: say {PACKAGE}.filters"


@pytest.mark.parametrize("module", MODULES)
def test_only_one_layer_talks_to_each_library(module):
    doors = {"pymeshlab": "host", "sklearn": "clustering", "click": "cli", "rich": "cli"}
    for name, line in imports(MODULES[module]):
        door = doors.get(name.split(".")[0])
        assert door in (None, part(module)), f"{module}:{line}: only {door} may import {name}"


def test_symmetry_and_powercrust_do_not_know_each_other():
    assert "powercrust" not in ALLOWED["symmetry"]
    assert "symmetry" not in ALLOWED["powercrust"]


def test_the_table_has_no_circles():
    done = set()
    while len(done) < len(ALLOWED):
        ready = {name for name, needs in ALLOWED.items() if needs & set(ALLOWED) <= done} - done
        assert ready, f"{set(ALLOWED) - done} import each other in a circle"
        done |= ready


def test_the_reader_of_imports_sees_every_form(tmp_path):
    path = tmp_path / "example.py"
    path.write_text(
        "import pymeshlab.x\nfrom . import a\nfrom ..b import c\n"
        "def later():\n    from meshlab_symrecon import host\n"
    )
    names = [name for name, _ in imports(path)]
    assert names == ["pymeshlab.x", ".", "..b", PACKAGE, f"{PACKAGE}.host"]


WITHOUT = """
import sys
sys.modules["pymeshlab"] = None  # importing it raises ImportError
import importlib
for name in {names}:
    importlib.import_module(name)
"""


def test_all_but_the_host_and_the_command_line_import_without_pymeshlab():
    names = [module for module in MODULES if part(module) not in ("host", "cli")]
    subprocess.run([sys.executable, "-c", WITHOUT.format(names=names)], check=True)


LIGHT = """
import sys, meshlab_symrecon
meshlab_symrecon.__version__
heavy = {"pymeshlab", "numpy", "scipy", "sklearn"} & set(sys.modules)
assert not heavy, heavy
"""


def test_the_package_imports_nothing_heavy():
    subprocess.run([sys.executable, "-c", LIGHT], check=True)
