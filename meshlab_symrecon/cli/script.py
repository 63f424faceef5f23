"""``symrecon run``: a filter script on files."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import click

from meshlab_symrecon.cli.progress import progress_bar

__all__ = ["run"]


@click.command()
@click.argument("script", type=click.Path(path_type=Path), metavar="SCRIPT.mlx")
@click.argument("inputs", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="IN...")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    metavar="OUT",
    help="File of the layer that is current at the end.",
)
@click.option(
    "--json", "report", type=click.Path(path_type=Path), metavar="R.json",
    help="Also save what became of every step.",
)  # fmt: skip
def run(script: Path, inputs: tuple[Path, ...], output: Path, report: Path | None) -> None:
    """Run a MeshLab filter script, old or new, on IN... and save the current layer.

    The inputs become layers in their order; the last one is the current one. The whole script is
    checked before anything runs.
    """
    from meshlab_symrecon.cli.reports import write_json
    from meshlab_symrecon.host.files import check_output, load, new_document, save_current
    from meshlab_symrecon.host.mlx import read_script
    from meshlab_symrecon.host.resolution import resolve_script
    from meshlab_symrecon.host.script import run_script

    check_output(output, [script, *inputs])
    if report is not None:
        check_output(report, [script, *inputs, output], ())
    resolve_script(read_script(script))  # before the inputs are read, which may take long
    mesh_set = new_document()
    for path in inputs:
        load(path, mesh_set)
    with progress_bar(script.name) as progress:
        result = run_script(mesh_set, script, progress=progress)
    save_current(mesh_set, output)
    if report is not None:
        files = {"inputs": [str(path) for path in inputs], "output": str(output)}
        write_json(report, dataclasses.asdict(result) | files)
    for step in result.steps:
        _say(step)
    click.echo(f"{len(result.steps)} steps in {result.seconds:.1f} s, written {output}")


def _say(step: Any) -> None:
    from meshlab_symrecon.cli.reports import measures_in_words

    click.echo(f"{step.file}:{step.line}: {step.status} {step.filter} ({step.seconds:.2f} s)")
    for line in (*step.notes, *measures_in_words(step.measures)):
        click.echo(f"    {line}")
