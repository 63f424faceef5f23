"""The report of a reconstruction: its layers as arrays, its words, one page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from meshlab_symrecon.host.reconstruction import COMPLETED, SCAN, SURFACE, Reconstruction

if TYPE_CHECKING:
    from meshlab_symrecon.pictures.report_scene import ReportScene

__all__ = ["scene_of", "write_report"]


def write_report(path: Path, scan: Path, result: Reconstruction, command: str) -> None:
    """Write a reconstruction as one page, whole or not at all.

    Raises
    ------
    FileError
        The page cannot be written, or the scan cannot be read again.
    SymReconError
        plotly or matplotlib is missing.
    """
    from meshlab_symrecon.cli.deviation import measured_deviation
    from meshlab_symrecon.cli.report_words import words_of
    from meshlab_symrecon.host.atomic import replacing
    from meshlab_symrecon.pictures.report import report_page

    deviation = measured_deviation(result)
    signed = bool(deviation.measures.get("signed", True))
    scene = replace(scene_of(result), deviation=deviation.distances, signed=signed)
    page = report_page(scene, words_of(scan, result, scene, deviation, command))
    with replacing(path) as staged:
        staged.write_bytes(page.encode("utf-8", "backslashreplace"))


def scene_of(result: Reconstruction) -> ReportScene:
    """Return what there is to see: the arrays of the layers, in world coordinates."""
    import numpy as np

    from meshlab_symrecon.host.meshset import read_layer
    from meshlab_symrecon.pictures.report_scene import ReportScene

    layers = {label: read_layer(result.mesh_set, n) for label, n in result.layers.items()}
    measured, surface = layers[SCAN], layers[SURFACE]
    completed = layers.get(COMPLETED, measured)
    share = surface.quality if surface.quality is not None else np.zeros(len(surface.points))
    return ReportScene(
        scan=measured.points,
        planes=np.reshape(result.found["planes"], (-1, 4)),
        completed=completed.points,
        mirrored=np.arange(len(completed.points)) >= len(measured.points),
        surface=surface.points,
        faces=surface.faces,
        share=share,
        scan_normals=measured.normals,
        completed_normals=completed.normals,
    )
