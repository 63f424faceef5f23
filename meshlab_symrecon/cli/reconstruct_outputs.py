"""What ``symrecon reconstruct`` writes: checked before the work, written after it."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import SymReconError
from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.files import save_current
from meshlab_symrecon.host.paths import check_output
from meshlab_symrecon.host.projects import PROJECT, layer_files, save_project
from meshlab_symrecon.host.reconstruction import LABELS, Reconstruction
from meshlab_symrecon.host.records import record_of

__all__ = ["METHOD_DONE", "Outputs", "check_outputs", "write_outputs"]

PICTURES = ("png",)
PAGES = ("html", "htm")
# Shares of the whole command that are done.
METHOD_DONE, SURFACE_WRITTEN, PROJECT_WRITTEN, PREVIEW_DRAWN = 0.96, 0.97, 0.98, 0.99


@dataclass(frozen=True, slots=True)
class Outputs:
    """Where the results go."""

    surface: Path
    project: Path | None = None
    json: Path | None = None
    preview: Path | None = None
    report: Path | None = None


def check_outputs(scan: Path, outputs: Outputs) -> None:
    """Refuse every bad output path, and what needs a missing library, before the work starts.

    Raises
    ------
    FileError
        As ``check_output``.
    SymReconError
        matplotlib or plotly is missing.
    """
    check_output(outputs.surface, [scan])
    used = [scan, outputs.surface]
    others = (
        (outputs.project, (PROJECT,)), (outputs.json, ()), (outputs.preview, PICTURES),
        (outputs.report, PAGES),
    )  # fmt: skip
    for path, known in others:
        if path is not None:
            check_output(path, used, known)
            used.append(path)
    if outputs.project is not None:
        for name in layer_files(outputs.project, dict(enumerate(LABELS))).values():
            check_output(outputs.project.parent / name, used)
    _check_libraries(outputs)


def _check_libraries(outputs: Outputs) -> None:
    for option, path, libraries in (
        ("--preview", outputs.preview, ("matplotlib",)),
        ("--report", outputs.report, ("plotly", "matplotlib")),
    ):
        for library in libraries if path is not None else ():
            if find_spec(library) is None:
                message = (
                    f"{option} needs {library}, which is not installed; run "
                    "pip install 'meshlab-symrecon[report]'"
                )
                raise SymReconError(message)


def write_outputs(
    scan: Path,
    outputs: Outputs,
    result: Reconstruction,
    settings: Mapping[str, Any],
    progress: Callable[[float, str], None],
) -> None:
    """Write all that was asked for but the JSON, which tells how long it took.

    Raises
    ------
    FileError
        The system refused.
    """
    progress(METHOD_DONE, f"writing {outputs.surface}")
    # The others are parameters of the steps, which the record has anyway.
    own = {name: settings[name] for name in ("max_points",) if name in settings}
    record = record_of(result.mesh_set, [scan], own)
    save_current(result.mesh_set, outputs.surface, record)
    if outputs.project is not None:
        progress(SURFACE_WRITTEN, f"writing {outputs.project}")
        labels = {identifier: label for label, identifier in result.layers.items()}
        inputs = [scan, outputs.surface]
        save_project(result.mesh_set, outputs.project, inputs, labels, record)
    if outputs.preview is not None:
        progress(PROJECT_WRITTEN, f"drawing {outputs.preview}")
        with replacing(outputs.preview) as staged:
            _draw(scan, result, staged)
    if outputs.report is not None:
        from meshlab_symrecon.cli.report import write_report

        progress(PREVIEW_DRAWN, f"drawing {outputs.report}")
        write_report(outputs.report, scan, result, command_line(scan, outputs, settings))
    progress(1.0, "")


def command_line(scan: Path, outputs: Outputs, settings: Mapping[str, Any]) -> str:
    """Return the command that gives these outputs again."""
    options = {
        "-o": outputs.surface,
        "--project": outputs.project,
        "--json": outputs.json,
        "--preview": outputs.preview,
        "--report": outputs.report,
        "--seed": settings["randomseed"],
        "--max-points": settings.get("max_points"),
    }
    given = [(name, str(value)) for name, value in options.items() if value is not None]
    flags = ["--paint"] if settings["paint"] else []
    return shlex.join(["symrecon", "reconstruct", str(scan), *chain.from_iterable(given), *flags])


def _draw(scan: Path, result: Reconstruction, path: Path) -> None:
    from meshlab_symrecon.cli.report import scene_of
    from meshlab_symrecon.pictures.main_job import main_job_picture

    seen = scene_of(result)
    main_job_picture(
        seen.scan, seen.planes, seen.completed, seen.mirrored, seen.surface, seen.faces,
        seen.share, path, title=scan.name,
    )  # fmt: skip
