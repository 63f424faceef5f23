"""What the report of a reconstruction says: the summary, the numbers, the planes, the files."""

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
from meshlab_symrecon.cli.method import Reconstruction
from meshlab_symrecon.cli.report_recipe import recipe, steps
from meshlab_symrecon.cli.reports import detection
from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.atomic import reason
from meshlab_symrecon.pictures.report import ReportWords, Section, Table
from meshlab_symrecon.pictures.report_scene import ReportScene

__all__ = ["words_of"]

DOUBTFUL = 0.8  # confidence below which the page asks people to look at the plane first
LIBRARIES = ("pymeshlab", "numpy", "scipy", "scikit-learn", "plotly")
MEASURES = {
    "measured": "Measured points",
    "mirrored": "Invented points",
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
UNEQUAL = ("seconds",)  # measures that differ from run to run, so that pages would, too
PLANE_WORDS = (
    "A plane is the set of points (x, y, z) with A x + B y + C z + D = 0, in the coordinates of "
    "the file. Support is the share of points that have a mirror partner; residual the root mean "
    "square distance between partners, as a share of the diagonal of the scan's box; confidence "
    "how sure the detection is of the plane, from 0 (a guess) to 1 (certain)."
)


def words_of(scan: Path, result: Reconstruction, scene: ReportScene, command: str) -> ReportWords:
    """Return everything that the page says.

    Raises
    ------
    FileError
        The scan cannot be read again for its checksum.
    """
    planes = detection(result.found)["planes"]
    sections = [Section("Numbers", (_numbers(result, scene),))]
    if planes:
        sections.append(Section("Mirror planes", (_plane_table(planes), PLANE_WORDS)))
    sections += [*steps(result), *recipe(result, scan, command)]
    sections.append(Section("Files and versions", (_files(scan),)))
    return ReportWords(
        title=scan.name,
        summary=tuple(_summary(result, scene, planes)),
        warnings=tuple(_warnings(result, planes)),
        sections=tuple(sections),
        footer=f"Written by meshlab_symrecon {__version__}. The page needs no network.",
    )


def _summary(
    result: Reconstruction, scene: ReportScene, planes: Sequence[Mapping[str, Any]]
) -> list[str]:
    """Say in plain sentences what was found, what was invented and what came out."""
    if planes:
        invented = _percent(scene.invented_area()[1])
        return [
            _found(result, scene, planes),
            f"{_shape(result, scene)} {invented} of its area is invented.",
            "What is invented shows what the other side looks like. It is a conjecture about what "
            "this side was, and only as good as the mirror plane.",
        ]
    return [
        f"In this scan of {_counted(result.points, 'point')} no mirror plane was found that can be "
        "trusted, so nothing was invented: the surface closes what was measured.",
        _shape(result, scene),
        "Where the scan has holes, the surface bridges them smoothly.",
    ]


def _found(result: Reconstruction, scene: ReportScene, planes: Sequence[Mapping[str, Any]]) -> str:
    sure = _listed([f"{plane['confidence']:.2f}" for plane in planes])
    several = f"{len(planes)} mirror planes were found"
    added, all_points = int(scene.mirrored.sum()), len(scene.completed)
    return (
        f"In this scan of {_counted(result.points, 'point')} "
        f"{'one mirror plane was found' if len(planes) == 1 else several} (confidence {sure}). "
        f"{_counted(added, 'point')} {'was' if added == 1 else 'were'} invented, by mirroring "
        f"measured points to where nothing was measured: {_percent(added / max(all_points, 1))} "
        f"of the {_counted(all_points, 'point')} that the surface was made from."
    )


def _shape(result: Reconstruction, scene: ReportScene) -> str:
    """Say what kind of surface came out."""
    shape = result.surface
    closed = "closed (it bounds a solid)" if shape["closed"] else "NOT closed (it has open edges)"
    pieces = "one piece" if shape["components"] == 1 else f"{shape['components']} pieces"
    genus = int(shape["genus"])
    handles = {-1: "", 0: ", without handles"}.get(genus, f", with {_counted(genus, 'handle')}")
    triangles = _counted(len(scene.faces), "triangle")
    return f"The surface is {closed}, in {pieces}{handles}, and has {triangles}."


def _warnings(result: Reconstruction, planes: Sequence[Mapping[str, Any]]) -> list[str]:
    said = [f"{sentence[:1].upper()}{sentence[1:]}." for sentence in result.warnings]
    if not result.found["converged"]:
        said.append("The clustering stopped before it had converged; planes may be missing.")
    if planes and planes[0]["confidence"] < DOUBTFUL:
        said.append(
            f"The best mirror plane has a confidence of {planes[0]['confidence']:.2f} only. Look "
            "at it before you trust what is invented."
        )
    return said


def _numbers(result: Reconstruction, scene: ReportScene) -> Table:
    """Return every measure of the filters, and what can be reckoned from the layers."""
    area, invented = scene.invented_area()
    lengths = " x ".join(_rounded(length) for length in np.ptp(scene.scan, axis=0))
    measured = {
        name: value
        for measures in (result.completed, result.surface)
        for name, value in measures.items()
        if name not in UNEQUAL
    }
    rows = [("Box of the scan, in the file's unit", lengths)]
    rows += [(_label(name), _value(value)) for name, value in measured.items()]
    rows.append(("Surface: area, in squares of the file's unit", _rounded(area)))
    rows.append(("Surface: share of the area that is invented", _percent(invented)))
    return Table(("What", "Value"), tuple(rows))


def _label(name: str) -> str:
    return MEASURES.get(name, name.replace("_", " ").capitalize())


def _value(value: Any) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (int, np.integer)):
        return f"{int(value):,}"
    if isinstance(value, (Number, np.floating)):
        return _rounded(float(value))  # type: ignore[arg-type]
    if isinstance(value, Mapping):
        return "; ".join(f"{name}: {_value(item)}" for name, item in value.items())
    if isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str):
        return ", ".join(_value(item) for item in value)
    return str(value)


def _rounded(number: float) -> str:
    """Write five digits, without an exponent where that is readable."""
    if number != 0.0 and not 1e-4 <= abs(number) < 1e9:
        return f"{number:.4e}"
    return f"{float(f'{number:.5g}'):,}".removesuffix(".0")


def _plane_table(planes: Sequence[Mapping[str, Any]]) -> Table:
    columns = ("Plane", "A", "B", "C", "D", "Support", "Residual", "Confidence")
    rows = [
        (
            str(number), *(f"{value:.8g}" for value in plane["plane"]), f"{plane['support']:.3f}",
            f"{plane['residual']:.2g}", f"{plane['confidence']:.3f}",
        )
        for number, plane in enumerate(planes, start=1)
    ]  # fmt: skip
    return Table(columns, tuple(rows))


def _files(scan: Path) -> Table:
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


def _counted(number: int, what: str) -> str:
    return f"{number:,} {what}" + ("" if number == 1 else "s")


def _percent(share: float) -> str:
    shown = 100.0 * share
    return f"{shown:.0f} %" if shown >= 10.0 or shown == 0.0 else f"{shown:.1f} %"


def _listed(items: Sequence[str]) -> str:
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)
