"""``symrecon run``: a filter script on files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from meshlab_symrecon.cli.file_path import FilePath
from meshlab_symrecon.cli.long_work import LongWork, long_work, max_points_option

__all__ = ["run"]


@click.command()
@click.argument("script", type=FilePath(), metavar="SCRIPT.mlx")
@click.argument("inputs", nargs=-1, type=FilePath(), metavar="[IN]...")
@click.option(
    "-o",
    "--output",
    type=FilePath(),
    required=True,
    metavar="OUT",
    help="File of the layer that is current at the end; all layers for a .mlp.",
)
@click.option("--strict", is_flag=True, help="Refuse a script that is not quite of today.")
@click.option("--lenient", is_flag=True, help="Pass over steps that cannot run, and say which.")
@click.option(
    "--isolate", is_flag=True, help="Work in a child process: a crash in MeshLab is an error."
)
@click.option(
    "--json", "report", type=FilePath(), metavar="R.json",
    help="Also save what became of every step, with its parameters.",
)  # fmt: skip
@max_points_option
@long_work
def run(
    script: Path,
    inputs: tuple[Path, ...],
    output: Path,
    report: Path | None,
    max_points: int | None,
    *,
    work: LongWork,
    **how: bool,
) -> None:
    """Run a MeshLab filter script, old or new, on IN... and save the current layer.

    The inputs, meshes or projects, become layers in their order; the last one is the current one.
    Without any, the script has to make the first layer. The whole script is checked before
    anything runs.
    """
    from meshlab_symrecon.cli.reports import plain, write_json
    from meshlab_symrecon.host.file_job import Manner, run_on_files
    from meshlab_symrecon.host.paths import check_output
    from meshlab_symrecon.host.projects import files_of
    from meshlab_symrecon.host.records import versions

    if how["strict"] and how["lenient"]:
        raise click.UsageError("--strict and --lenient contradict each other; give one")
    if report is not None:
        kept = [file for path in inputs for file in files_of(path)]
        check_output(report, [script, *kept, output], ())
    with work.progress(script.name) as progress:
        manner = Manner(**how, most=max_points)
        result = run_on_files(script, inputs, output, manner, progress)
    if report is not None:
        files = {"inputs": [str(path) for path in inputs], "output": str(output)}
        settings = {} if max_points is None else {"max_points": max_points}
        write_json(report, plain(result) | files | settings | {"versions": versions()})
    for thinned in result.thinned:
        work.say(f"{thinned.path}: thinned out from {thinned.measured} to {thinned.points} points")
    for step in result.steps:
        for line in _in_words(step):
            work.say(line)
    work.say(f"{_count(result.steps)} in {result.seconds:.1f} s, written {output}")


def _count(steps: Any) -> str:
    skipped = sum(step.status == "skipped" for step in steps)
    count = "1 step" if len(steps) == 1 else f"{len(steps)} steps"
    return count + (f" ({skipped} skipped)" if skipped else "")


def _in_words(step: Any) -> list[str]:
    from meshlab_symrecon.cli.reports import measures_in_words

    name = step.filter or f"'{step.name.strip()}'"
    lines = (*step.notes, *measures_in_words(step.measures))
    return [
        f"{step.file}:{step.line}: {step.status} {name} ({step.seconds:.2f} s)",
        *(f"    {line}" for line in lines),
    ]
