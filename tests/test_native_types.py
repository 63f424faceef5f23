"""The types of the compiled kernel, beside the kernel itself."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from meshlab_symrecon import _native

ROOT = Path(__file__).parents[1]
TYPES = ast.parse((ROOT / "meshlab_symrecon" / "_native.pyi").read_text(encoding="utf-8"))
NAMES = {name for name in dir(_native) if not name.startswith("_")}
FUNCTIONS = [node for node in TYPES.body if isinstance(node, ast.FunctionDef)]
CLASSES = [node for node in TYPES.body if isinstance(node, ast.ClassDef)]


def test_every_name_of_the_kernel_has_a_type():
    assert sorted(node.name for node in FUNCTIONS + CLASSES) == sorted(NAMES)


@pytest.mark.parametrize("typed", FUNCTIONS, ids=lambda node: node.name)
def test_types_name_the_parameters_as_the_kernel_does(typed):
    signature = getattr(_native, typed.name).__doc__.partition(" -> ")[0]
    bound = re.findall(r"(?:\(|, )(\w+): ", signature)
    assert [argument.arg for argument in typed.args.args] == bound


@pytest.mark.parametrize("name", sorted(NAMES))
def test_every_name_of_the_kernel_is_used(name):
    sources = [*(ROOT / "meshlab_symrecon").rglob("*.py"), *(ROOT / "tests").rglob("*.py")]
    assert any(f"_native.{name}" in path.read_text(encoding="utf-8") for path in sources)
