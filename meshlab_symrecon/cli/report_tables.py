"""The tables of a report: numbers, planes, files and versions; and how numbers are written."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from numbers import Number
from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon import __version__
from meshlab_symrecon.arrays import Floats
from meshlab_symrecon.cli.deviation import Deviation
from meshlab_symrecon.cli.unfilled import holes, place, width
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.atomic import reason
from meshlab_symrecon.host.reconstruction import Reconstruction
from meshlab_symrecon.pictures.report import Table
from meshlab_symrecon.pictures.report_scene import ReportScene

__all__ = [
    "counted",
    "files_table",
    "holes_table",
    "numbers_table",
    "percent",
    "planes_table",
    "rounded",
]

LIBRARIES = ("pymeshlab", "numpy", "scipy", "scikit-learn", "plotly")
MEASURES = {
    "measured": "Measured points",
    "mirrored": "Invented points",
    "scattered": "Points not mirrored, since they lie on no surface",
    "plinth": "Points not mirrored, of a plinth that is not its own mirror image",
    "open_rims": "Holes missing on both sides",
    "edge_manifold": "Surface: no edge has more than two faces",
    "vertex_manifold": "Surface: the faces round every vertex form one fan",
    "closed": "Surface: closed",
    "components": "Surface: pieces",
    "genus": "Surface: handles (genus)",
    "vertices": "Surface: vertices",
    "faces": "Surface: faces",
    "largest_cap": "Widest hole of the scan that was closed, in point spacings there",
    "opened_caps": "Holes left open",
    "outliers": "Points left out as outliers",
    "poles": "Poles (centres of the balls that make the surface)",
    "dropped_poles": "Poles dropped for their size",
    "unlabelled_poles": "Poles that no evidence reached",
    "flipped_poles": "Poles of pieces too small to keep",
}
DEVIATIONS = {
    "median": "Deviation from the mirror image: median, without signs",
    "percentile_95": "Deviation: 95 % of the points stay below",
    "rms": "Deviation: root mean square",
    "within_tolerance": "Deviation: share of the points within the tolerance",
    "without_counterpart": "Deviation: share of the points without a counterpart",
    "tolerance": "Deviation: the tolerance, in the file's unit",
    "signed": "Deviation: told inside from outside",
    "plane": "Deviation: across the plane (A, B, C, D)",
}
HOLES = "open_rims"
UNEQUAL = ("seconds",)  # measures that differ from run to run, so that pages would, too


def numbers_table(result: Reconstruction, scene: ReportScene, deviation: Deviation) -> Table:
    """Return every measure of the filters, and what can be reckoned from the layers."""
    area, invented = scene.invented_area()
    lengths = " x ".join(rounded(length) for length in np.ptp(scene.scan, axis=0))
    measured = {
        name: value
        for measures in (result.completed, result.surface)
        for name, value in measures.items()
        if name not in UNEQUAL
    }
    if HOLES in measured:
        measured[HOLES] = len(holes(result.completed))  # where they are has a table of its own
    rows = [("Box of the scan, in the file's unit", lengths)]
    rows += [(_label(name), _value(value)) for name, value in measured.items()]
    rows.append(("Surface: area, in squares of the file's unit", rounded(area)))
    rows.append(("Surface: share of the area that is invented", percent(invented)))
    rows += [
        (_label(name, DEVIATIONS), _value(value)) for name, value in deviation.measures.items()
    ]
    return Table(("What", "Value"), tuple(rows))


def _label(name: str, known: Mapping[str, str] = MEASURES) -> str:
    return known.get(name, name.replace("_", " ").capitalize())


def _value(value: Any) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (int, np.integer)):
        return f"{int(value):,}"
    if isinstance(value, (Number, np.floating)):
        return rounded(float(value))  # type: ignore[arg-type]
    if isinstance(value, Mapping):
        return "; ".join(f"{name}: {_value(item)}" for name, item in value.items())
    if isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str):
        return ", ".join(_value(item) for item in value) or "none"
    return str(value)


def rounded(number: float) -> str:
    """Write five digits, without an exponent where that is readable."""
    if number != 0.0 and not 1e-4 <= abs(number) < 1e9:
        return f"{number:.4e}"
    return f"{float(f'{number:.5g}'):,}".removesuffix(".0")


def planes_table(planes: Sequence[Mapping[str, Any]]) -> Table:
    """Return the planes, best first."""
    columns = ("Plane", "A", "B", "C", "D", "Support", "Residual", "Confidence")
    rows = [
        (
            str(number), *(f"{value:.8g}" for value in plane["plane"]), f"{plane['support']:.3f}",
            f"{plane['residual']:.2g}", f"{plane['confidence']:.3f}",
        )
        for number, plane in enumerate(planes, start=1)
    ]  # fmt: skip
    return Table(columns, tuple(rows))


def holes_table(unfilled: Floats) -> Table:
    """Return width and place of holes (k, 4), widest first."""
    rows = [(str(n), width(hole), place(hole)) for n, hole in enumerate(unfilled, start=1)]
    return Table(("Hole", "Width", "Place (x, y, z)"), tuple(rows))


def files_table(scan: Path) -> Table:
    """Return what is needed to know the scan and the programs again.

    Raises
    ------
    FileError
        The scan cannot be read again for its checksum.
    """
    digest, size = _checksum(scan)
    rows = [
        ("Scan", scan.name),
        ("Size of the scan", f"{size:,} bytes"),
        ("SHA-256 of the scan", digest),
        ("meshlab_symrecon", __version__),
        *((name, version(name)) for name in LIBRARIES),
        ("Python", platform.python_version()),
        ("System", f"{platform.system()} {platform.machine()}"),
    ]
    return Table(("What", "Which"), tuple(rows))


def _checksum(path: Path) -> tuple[str, int]:
    digest, size = hashlib.sha256(), 0
    try:
        with path.open("rb") as file:
            while block := file.read(1 << 20):
                digest.update(block)
                size += len(block)
    except OSError as error:
        raise FileError(f"{path} cannot be read again: {reason(error)}; leave it there") from error
    return digest.hexdigest(), size


def counted(number: int, what: str) -> str:
    """Write a number of things."""
    return f"{number:,} {what}" + ("" if number == 1 else "s")


def percent(share: float) -> str:
    """Write a share of 0 to 1."""
    shown = 100.0 * share
    return f"{shown:.0f} %" if shown >= 9.95 or shown == 0.0 else f"{shown:.1f} %"
