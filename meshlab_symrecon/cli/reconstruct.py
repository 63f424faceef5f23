"""``symrecon reconstruct``: the whole method, from a scan to a closed statue."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import click

from meshlab_symrecon.cli.file_path import FilePath
from meshlab_symrecon.cli.long_work import LongWork, long_work, max_points_option

__all__ = ["reconstruct"]

SEED_LIMIT = 2**31 - 1


@click.command()
@click.argument("scan", type=FilePath())
@click.option(
    "-o",
    "--output",
    type=FilePath(),
    required=True,
    metavar="STATUE",
    help="File of the closed surface; the extension chooses the format, .ply keeps everything.",
)
@click.option(
    "--project",
    type=FilePath(),
    metavar="P.mlp",
    help="Also save every layer, and a MeshLab project that lists them.",
)
@click.option(
    "--json",
    "json_path",
    type=FilePath(),
    metavar="R.json",
    help="Also save what was found and measured.",
)
@click.option(
    "--preview",
    type=FilePath(),
    metavar="P.png",
    help="Also draw scan, plane and surface side by side (needs matplotlib).",
)
@click.option(
    "--report",
    type=FilePath(),
    metavar="R.html",
    help="Also write a page to judge and repeat the result by: a view to turn, what was found and "
    "invented, every parameter and version (needs plotly and matplotlib).",
)
@click.option(
    "--seed", "randomseed", type=click.IntRange(0, SEED_LIMIT), default=0, show_default=True,
    help="Seed of what is random; equal seeds give equal results.",
)  # fmt: skip
@max_points_option
@click.option(
    "--paint", is_flag=True,
    help="Colour the completed points and the surface by what was measured and what was invented.",
)  # fmt: skip
@long_work
def reconstruct(
    scan: Path,
    output: Path,
    project: Path | None,
    json_path: Path | None,
    preview: Path | None,
    report: Path | None,
    *,
    work: LongWork,
    **settings: Any,
) -> None:
    """Complete SCAN from its own mirror symmetry and close it with the Power Crust.

    Says what it found. When SCAN has no mirror plane, a warning says so and the surface closes
    what was measured.
    """
    from meshlab_symrecon.cli.reconstruct_findings import as_data, in_words
    from meshlab_symrecon.cli.reconstruct_outputs import (
        METHOD_DONE,
        Outputs,
        check_outputs,
        write_outputs,
    )
    from meshlab_symrecon.cli.reports import write_json
    from meshlab_symrecon.host.atomic import together
    from meshlab_symrecon.host.reconstruction import whole_method

    started = time.perf_counter()
    outputs = Outputs(output, project, json_path, preview, report)
    check_outputs(scan, outputs)
    most = settings.pop("max_points")
    with together(), work.progress("reconstructing") as progress:
        result = whole_method(
            scan,
            settings,
            lambda fraction, message: progress(METHOD_DONE * fraction, message),
            most=most,
        )
        settings |= {} if most is None else {"max_points": most}
        write_outputs(scan, outputs, result, settings, progress)
        seconds = time.perf_counter() - started
        if json_path is not None:
            write_json(json_path, as_data(scan, outputs, result, settings, seconds))
    for line in in_words(scan, result):
        work.say(line)
    work.say(f"written         {output} in {seconds:.1f} s")
