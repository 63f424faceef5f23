"""The documented chain of filters on one scan, from the measured points to the closed surface."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import SymReconWarning
from meshlab_symrecon.host.files import load
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.paths import check_input
from meshlab_symrecon.host.registration import apply_filter, registry
from meshlab_symrecon.host.size import RECONSTRUCT, check_memory, check_rest
from meshlab_symrecon.host.thinning import thin_current

__all__ = [
    "CLOSE",
    "COMPLETE",
    "COMPLETED",
    "DETECT",
    "LABELS",
    "PLANES",
    "SCAN",
    "SURFACE",
    "Reconstruction",
    "noted",
    "parameters_as_run",
    "whole_method",
]

NORMALS = "compute_normal_for_point_clouds"
DETECT = "generate_reflection_planes"
COMPLETE = "generate_mirror_completed_points"
CLOSE = "generate_surface_reconstruction_power_crust"
# Seconds that each step takes at least, and for a million points, on one core: for the progress.
SECONDS = {NORMALS: (0.1, 4.5), DETECT: (1.5, 1.0), COMPLETE: (0.5, 5.5), CLOSE: (0.5, 34.0)}
READ = 0.01  # share of the time for reading
SCAN, PLANES, COMPLETED, SURFACE = LABELS = (
    "scan", "reflection planes", "completed points", "surface",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Reconstruction:
    """The document after the whole method, its layers, what each filter measured and warned of."""

    mesh_set: Any
    layers: Mapping[str, int]  # label: identifier
    points: int
    found: Mapping[str, Any]
    completed: Mapping[str, Any]
    surface: Mapping[str, Any]
    warnings: tuple[str, ...] = ()
    measured: int = 0  # points of the file, of which ``points`` are left when it was thinned out


def whole_method(
    scan: Path,
    settings: Mapping[str, Any],
    progress: Callable[[float, str], None],
    most: int | None = None,
    limit: int | None = None,
) -> Reconstruction:
    """Load a scan and run the filters of the documented chain on it.

    Parameters
    ----------
    scan : Path
    settings : mapping
        Parameters; each goes to every filter that has one of its name.
    progress : callable
        Called with a fraction and a message.
    most : int, optional
        A scan with more points is thinned out evenly to these first.
    limit : int, optional
        Bytes that the whole process may take; what is available when left out.

    Returns
    -------
    Reconstruction
        In a document of its own, whose first layer is the scan as it was worked on.

    Raises
    ------
    SizeError
        The work would need more memory than there is; told before it starts, or, where the file
        does not tell its size or more was missing than is usual, before the step that needs it.
    FileError, GeometryError, ParameterError, HostError
        As ``load``, ``thin_current`` and ``apply_filter``.
    """
    check_input(scan)
    check_memory(scan, limit, most=most)
    with noted() as sentences:
        result = _run_all(scan, settings, progress, most, limit)
    return replace(result, warnings=tuple(sentences))


@contextmanager
def noted() -> Iterator[list[str]]:
    """Yield a list that holds our warnings' sentences at the end; all warnings are given then."""
    sentences: list[str] = []
    caught: list[warnings.WarningMessage] = []
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield sentences
    finally:
        for warning in caught:
            if issubclass(warning.category, SymReconWarning):
                sentences.append(str(warning.message))
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )


def _run_all(
    scan: Path,
    settings: Mapping[str, Any],
    progress: Callable[[float, str], None],
    most: int | None,
    limit: int | None,
) -> Reconstruction:
    progress(0.0, f"reading {scan.name}")
    mesh_set = load(scan)
    measured = _points(mesh_set)
    if most is not None and measured > most:
        progress(0.0, f"thinning out {measured} points")
        thin_current(mesh_set, most)
    layers = {SCAN: current_identifier(mesh_set)}
    points = _points(mesh_set)
    check_rest(scan, points, RECONSTRUCT, limit, measured=points)
    run = _runner(mesh_set, settings, progress, _shares(points))
    run(NORMALS, "normals")
    found = run(DETECT, "looking for mirror planes")
    completed: Mapping[str, Any] = {"measured": points, "mirrored": 0}
    if len(found["planes"]):
        layers[PLANES] = _newest(mesh_set)
        completed = run(COMPLETE, "mirroring points")
        layers[COMPLETED] = current_identifier(mesh_set)
    check_rest(scan, _points(mesh_set), (CLOSE,), limit, measured=points)
    surface = run(CLOSE, "closing the surface")
    layers[SURFACE] = current_identifier(mesh_set)
    return Reconstruction(mesh_set, layers, points, found, completed, surface, measured=measured)


def _points(mesh_set: Any) -> int:
    return int(mesh_set.current_mesh().vertex_number())


def _shares(points: int) -> dict[str, float]:
    """Return the share of the time that each step takes."""
    seconds = {name: least + million * points / 1e6 for name, (least, million) in SECONDS.items()}
    return {name: (1.0 - READ) * taken / sum(seconds.values()) for name, taken in seconds.items()}


def _runner(
    mesh_set: Any,
    settings: Mapping[str, Any],
    progress: Callable[[float, str], None],
    shares: Mapping[str, float],
) -> Callable[[str, str], Mapping[str, Any]]:
    """Return a function that runs one filter with its defaults and the settings."""
    done = READ

    def run(name: str, title: str) -> Mapping[str, Any]:
        nonlocal done
        start, share = done, shares[name]
        progress(start, title)
        measures = apply_filter(
            mesh_set,
            name,
            progress=lambda fraction, stage: progress(
                min(1.0, start + share * fraction), _stage(name, title, stage)
            ),
            **_set(name, settings),
        )
        done = start + share
        return measures

    return run


def _stage(name: str, title: str, stage: str) -> str:
    """Return what is being done, in words; MeshLab's own filters tell their names only."""
    return title if name == NORMALS or not stage else f"{title}: {stage}"


def _set(name: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that a filter has a parameter for."""
    declared = registry().find(name).parameters.declared() if name in registry() else ()
    names = {parameter.name for parameter in declared}
    return {key: value for key, value in settings.items() if key in names}


def _newest(mesh_set: Any) -> int:
    return max(int(mesh.id()) for mesh in mesh_set)


def parameters_as_run(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings, and every parameter of each of our filters as it ran."""
    bound = {
        name: registry().find(name).bind(_set(name, settings)).values()
        for name in (DETECT, COMPLETE, CLOSE)
    }
    return {**settings, **bound}
