"""The page of each filter: every declared fact is on it, it is current, its examples run."""

from __future__ import annotations

import re
import shlex
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import pymeshlab
import pytest
from click.testing import CliRunner

import meshlab_symrecon
from meshlab_symrecon.cli.filter_pages import filter_page, index_page, write_pages
from meshlab_symrecon.cli.main import main
from meshlab_symrecon.errors import FileError, SymReconWarning
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.resolution import resolve_script
from meshlab_symrecon.host.steps import registry
from meshlab_symrecon.plugin import ParameterSet
from meshlab_symrecon.plugin.filter import no_check

ROOT = Path(__file__).parents[2]
SCAN = ROOT / "examples/data/nefertiti_small.ply"
OURS = [item for item in registry() if item.run.__module__.startswith("meshlab_symrecon.")]
APPLY = sys.modules["meshlab_symrecon.cli.apply"]  # the name in the package is the command
EACH = pytest.mark.parametrize("item", OURS, ids=lambda item: item.python_name)


class Nothing(ParameterSet):
    """No parameters."""


def page_of(item):
    return ROOT.joinpath("docs/filters", f"{item.python_name}.md").read_text(encoding="utf-8")


def block(item, language):
    found = re.search(rf"```{language}\n(.*?)\n```", page_of(item), re.DOTALL)
    assert found is not None
    return found[1]


@pytest.fixture(scope="module")
def statue():
    """Return a document with a scan and its planes."""
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.load_new_mesh(str(SCAN))
    meshlab_symrecon.load_plugins()
    mesh_set.generate_reflection_planes()
    yield mesh_set
    meshlab_symrecon.unload_plugins()


def test_the_pages_are_up_to_date(tmp_path):
    written = {path.relative_to(tmp_path) for path in write_pages(OURS, tmp_path)}
    kept = {path.relative_to(ROOT / "docs") for path in ROOT.glob("docs/filters/*")}
    assert written == kept | {Path("filters.md")}
    for path in written:
        assert (ROOT / "docs" / path).read_bytes() == (tmp_path / path).read_bytes(), "make docs"


@EACH
def test_every_declared_fact_is_on_the_page(item):
    page = page_of(item)
    for fact in (*item.names, item.summary, item.meshlab_class, item.category, *item.creates):
        assert fact in page
    for need in item.requires:
        assert re.search(rf"\*Needs\*: .*{need}", page)
    for known in item.parameters.declared():
        kind = type(known.default).__name__
        line = f"- `{known.name} : {kind} = {known.default!r}`"
        about = f"*{known.label}*: {known.tooltip}\n"
        assert line in page
        assert page.index(line) < page.index(about, page.index(line))
        for word in known.choices:
            assert f"{known.choices.index(word)}: '{word}'" in page
    assert all(f"- {citation}" in page for citation in item.citations)
    assert f"](filters/{item.python_name}.md) | {item.summary} |" in index_page(OURS)


@EACH
def test_the_call_of_the_page_runs(item, statue):
    statue.set_current_mesh(0)
    names = {"ms": statue}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SymReconWarning)
        exec(block(item, "python"), names)
    told = page_of(item).partition("## Returns")[2].partition("## ")[0]
    assert names["measures"].keys() == {name for name in names["measures"] if f"`{name}`" in told}


@EACH
def test_the_step_of_the_page_is_the_filter_with_its_defaults(item, tmp_path):
    path = tmp_path / "step.mlx"
    path.write_text(f"<FilterScript>{block(item, 'xml')}</FilterScript>", encoding="utf-8")
    (resolved,) = resolve_script(read_script(path))
    assert resolved.filter is registry().find(item.python_name)
    assert list(resolved.values.items()) == [
        (known.name, known.default) for known in item.parameters.declared()
    ]
    assert resolved.notes == ()


@EACH
def test_the_command_of_the_page_is_understood(item, monkeypatch):
    heard = []
    monkeypatch.setattr(APPLY, "_run", lambda *given: heard.append(given[:-1]))  # but the work
    program, *words = shlex.split(block(item, "sh"))
    done = CliRunner().invoke(main, words)
    assert (program, done.exit_code) == ("symrecon", 0), done.output
    first = item.parameters.declared()[0]
    files = APPLY.Files((Path("scan.ply"),), Path("result.ply"), None, None)
    assert heard == [(item, files, {first.name: first.default})]


def test_a_bare_filter_has_a_short_page():
    bare = replace(
        OURS[0], aliases=(), parameters=Nothing, citations=(), requires=(), creates=(),
        description="Does it.", arity="SINGLE_MESH", check=no_check,
    )  # fmt: skip
    page = filter_page(bare)
    for text in (
        "- *Aliases*: none\n", "- *Needs*: nothing\n", "- *Makes*: no layer\n", "Does it.",
        "## Parameters\n\nNone.\n", f"ms.{bare.python_name}()\n",
    ):  # fmt: skip
        assert text in page
    assert "## Returns" not in page
    assert "## References" not in page


def test_the_command_prints_and_writes_pages(tmp_path):
    def run(*words):
        return CliRunner().invoke(main, ["filters", *words])

    assert run("--markdown").output == index_page(registry())
    assert run("--markdown", "power_crust_reconstruct").output == page_of(
        registry().find("power_crust_reconstruct")
    )
    done = run("--pages", str(tmp_path / "made"))
    assert done.exit_code == 0
    assert f"written {tmp_path / 'made/filters.md'}\n" in done.output
    assert run("--pages", str(tmp_path), "simplify_points").exit_code == 2


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "filters").write_text("a file", encoding="utf-8")
    with pytest.raises(FileError, match="filters cannot be made: File exists"):
        write_pages(OURS, tmp_path)
