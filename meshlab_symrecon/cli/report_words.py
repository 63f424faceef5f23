"""What the report of a reconstruction says: the summary, warnings, and the order of its parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from meshlab_symrecon import __version__
from meshlab_symrecon.cli.deviation import Deviation
from meshlab_symrecon.cli.report_recipe import recipe, steps
from meshlab_symrecon.cli.report_tables import (
    counted,
    files_table,
    holes_table,
    numbers_table,
    percent,
    planes_table,
)
from meshlab_symrecon.cli.reports import detection
from meshlab_symrecon.cli.unfilled import holes, left_alone, place, width
from meshlab_symrecon.host.reconstruction import Reconstruction
from meshlab_symrecon.pictures.report import ReportWords, Section
from meshlab_symrecon.pictures.report_scene import ReportScene

__all__ = ["words_of"]

DOUBTFUL = 0.8  # confidence below which the page asks people to look at the plane first
PLANE_WORDS = (
    "A plane is the set of points (x, y, z) with A x + B y + C z + D = 0, in the coordinates of "
    "the file. Support is the share of points that have a mirror partner; residual the root mean "
    "square distance between partners, as a share of the diagonal of the scan's box; confidence "
    "how sure the detection is of the plane, from 0 (a guess) to 1 (certain)."
)

HOLES_WORDS = (
    "Holes of the scan that are holes on the other side of the statue, too, or lie on the mirror "
    "plane itself, so that no mirror image fills them. The surface bridges them smoothly: what it "
    "shows there is neither measured nor mirrored. An open underside is counted as well. Width is "
    "the largest distance across, place the middle of the rim, both as in the file."
)


def words_of(
    scan: Path, result: Reconstruction, scene: ReportScene, deviation: Deviation, command: str
) -> ReportWords:
    """Return everything that the page says.

    Raises
    ------
    FileError
        The scan cannot be read again for its checksum.
    """
    planes = detection(result.found)["planes"]
    sections = [Section("Numbers", (numbers_table(result, scene, deviation),))]
    if planes:
        sections.append(Section("Mirror planes", (planes_table(planes), PLANE_WORDS)))
    unfilled = holes(result.completed)
    if len(unfilled):
        sections.append(Section("Missing on both sides", (holes_table(unfilled), HOLES_WORDS)))
    sections += [*steps(result, deviation.steps), *recipe(result, scan, command)]
    sections.append(Section("Files and versions", (files_table(scan),)))
    return ReportWords(
        title=scan.name,
        summary=tuple(_summary(result, scene, planes, deviation)),
        warnings=tuple(_warnings(result, planes, deviation)),
        sections=tuple(sections),
        footer=f"Written by meshlab_symrecon {__version__}. The page needs no network.",
    )


def _summary(
    result: Reconstruction,
    scene: ReportScene,
    planes: Sequence[Mapping[str, Any]],
    deviation: Deviation,
) -> list[str]:
    """Say in plain sentences what was found, what was invented and what came out."""
    if planes:
        invented = percent(scene.invented_area()[1])
        return [
            _found(result, scene, planes),
            *_left_alone(result),
            f"{_shape(result, scene)} {invented} of its area is invented.",
            *_unfilled(result),
            *_compared(deviation),
            "What is invented shows what the other side looks like. It is a conjecture about what "
            "this side was, and only as good as the mirror plane.",
        ]
    return [
        f"In this scan of {counted(result.points, 'point')} no mirror plane was found that can be "
        "trusted, so nothing was invented: the surface closes what was measured.",
        _shape(result, scene),
        "Where the scan has holes, the surface bridges them smoothly.",
    ]


def _found(result: Reconstruction, scene: ReportScene, planes: Sequence[Mapping[str, Any]]) -> str:
    sure = _listed([f"{plane['confidence']:.2f}" for plane in planes])
    several = f"{len(planes)} mirror planes were found"
    added, all_points = int(scene.mirrored.sum()), len(scene.completed)
    return (
        f"In this scan of {counted(result.points, 'point')} "
        f"{'one mirror plane was found' if len(planes) == 1 else several} (confidence {sure}). "
        f"{counted(added, 'point')} {'was' if added == 1 else 'were'} invented, by mirroring "
        f"measured points to where nothing was measured: {percent(added / max(all_points, 1))} "
        f"of the {counted(all_points, 'point')} of the completed scan."
    )


def _left_alone(result: Reconstruction) -> list[str]:
    """Say what was measured but not mirrored, if anything."""
    phrases = left_alone(result.completed, ",")
    return [f"Not mirrored: {_listed(phrases)}."] if phrases else []


def _unfilled(result: Reconstruction) -> list[str]:
    """Say what is missing on both sides, if anything."""
    unfilled = holes(result.completed)
    if len(unfilled) == 0:
        return []
    widest = f"{width(unfilled[0])} wide, in the file's unit, at {place(unfilled[0])}"
    if len(unfilled) == 1:
        return [
            f"One hole, {widest}, is missing on both sides of the statue, so that no mirror image "
            "fills it; the surface bridges it smoothly."
        ]
    return [
        f"{len(unfilled)} holes are missing on both sides of the statue, so that no mirror image "
        f"fills them; the surface bridges them smoothly. The widest is {widest}."
    ]


def _shape(result: Reconstruction, scene: ReportScene) -> str:
    """Say what kind of surface came out."""
    shape = result.surface
    closed = "closed (it bounds a solid)" if shape["closed"] else "NOT closed (it has open edges)"
    pieces = "one piece" if shape["components"] == 1 else f"{shape['components']} pieces"
    genus = int(shape["genus"])
    tunnels = f", with {counted(genus, 'handle')} (tunnels through it)"
    handles = {-1: "", 0: ", without handles"}.get(genus, tunnels)
    triangles = counted(len(scene.faces), "triangle")
    return f"The surface is {closed}, in {pieces}{handles}, and has {triangles}."


def _compared(deviation: Deviation) -> list[str]:
    """Say how far the two sides differ where both were measured."""
    found = deviation.measures
    if not found:
        return []
    return [
        f"Where both sides were measured, they differ by {found['median']:.2g} (median; 95 % "
        f"of the points by less than {found['percentile_95']:.2g}), in the file's unit; "
        f"{percent(found['without_counterpart'])} of the scan has no counterpart to compare with."
    ]


def _warnings(
    result: Reconstruction, planes: Sequence[Mapping[str, Any]], deviation: Deviation
) -> list[str]:
    sentences = (*result.warnings, *deviation.warnings)
    said = [f"{sentence[:1].upper()}{sentence[1:]}." for sentence in sentences]
    if not result.found["converged"]:
        said.append("The clustering stopped before it had converged; planes may be missing.")
    if planes and planes[0]["confidence"] < DOUBTFUL:
        said.append(
            f"The best mirror plane has a confidence of {planes[0]['confidence']:.2f} only. Look "
            "at it before you trust what is invented."
        )
    return said


def _listed(items: Sequence[str]) -> str:
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)
