"""What ``symrecon reconstruct`` has found: in words, and as data for JSON."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from meshlab_symrecon.cli.reconstruct_outputs import Outputs
from meshlab_symrecon.cli.reports import detection
from meshlab_symrecon.cli.unfilled import holes, left_alone, place, width
from meshlab_symrecon.host.measures import findings
from meshlab_symrecon.host.reconstruction import Reconstruction, parameters_as_run
from meshlab_symrecon.host.records import versions

__all__ = ["as_data", "in_words"]


def in_words(scan: Path, result: Reconstruction) -> list[str]:
    """Return what was found, one line a finding."""
    thinned = "" if result.measured in (0, result.points) else f", thinned out of {result.measured}"
    lines = [f"scan            {scan} with {result.points} points{thinned}"]
    planes = detection(result.found)["planes"]
    for plane in planes:
        numbers = " ".join(f"{number:.6g}" for number in plane["plane"])
        lines.append(f"mirror plane    {numbers} (A B C D), confidence {plane['confidence']:.2f}")
    if not planes:
        lines.append("mirror plane    none, so the surface closes what was measured")
    if not result.found["converged"]:
        lines.append("                the clustering stopped before it had converged")
    counts = result.completed
    lines.append(f"points          {counts['measured']} measured, {counts['mirrored']} mirrored")
    lines += [f"not mirrored    {phrase}" for phrase in left_alone(counts)]
    unfilled = holes(counts)
    if len(unfilled):
        several = "1 hole" if len(unfilled) == 1 else f"{len(unfilled)} holes, the widest"
        widest = f"{width(unfilled[0])} wide at {place(unfilled[0])}"
        lines.append(f"not filled      {several} {widest}: missing on both sides of the plane")
    measures = result.surface
    closed = "closed" if measures["closed"] else "NOT closed"
    components = measures["components"]
    pieces = f"{components} component" + ("" if components == 1 else "s")
    faces = f"{measures['faces']} faces"
    lines.append(f"surface         {closed}, genus {measures['genus']}, {pieces}, {faces}")
    return lines


def as_data(
    scan: Path,
    outputs: Outputs,
    result: Reconstruction,
    settings: Mapping[str, Any],
    seconds: float,
) -> dict[str, Any]:
    """Return everything that was found and measured; the planes as in every other report."""
    return {
        **findings(result),
        "seconds": seconds,
        "input": str(scan),
        "output": str(outputs.surface),
        "project": None if outputs.project is None else str(outputs.project),
        "parameters": parameters_as_run(settings),
        "versions": versions(),
    }
