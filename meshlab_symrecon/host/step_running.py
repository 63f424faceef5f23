"""One step of a script on a MeshSet."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.host.cloud_cleaning import reason_to_skip
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.native_filters import NativeFilter, apply_native, find_native
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.old_names import CHANGE_LAYER
from meshlab_symrecon.host.resolution import ResolvedStep
from meshlab_symrecon.host.run_values import noted_steps, values_of_run
from meshlab_symrecon.host.steps import run_filter
from meshlab_symrecon.plugin import Filter, Progress

__all__ = ["Ran", "run_resolved"]


@dataclass(frozen=True, slots=True)
class Ran:
    """What a step returned and ran with; as in ``StepReport``."""

    measures: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    then: Mapping[str, Any] = field(default_factory=dict)


def run_resolved(
    mesh_set: Any, resolved: ResolvedStep, meshes: Collection[int], progress: Progress
) -> Ran:
    """Run a step.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    resolved : ResolvedStep
    meshes : collection of int
        Identifiers of layers that have, or had, faces: of these a cleaning filter may delete every
        point.
    progress : callable

    Raises
    ------
    ParameterError
        A layer is not there, or as ``apply_filter``.
    GeometryError
        Every point would be deleted, or as ``apply_filter``.
    HostError
        MeshLab refused the step.
    """
    values = dict(resolved.values)
    for name in resolved.layers:
        values[name] = _identifier_at(mesh_set, name, values[name])
    if isinstance(resolved.filter, str):
        if resolved.filter == CHANGE_LAYER:
            mesh_set.set_current_mesh(values["mesh"])
        return Ran(parameters=dict(resolved.values))
    if isinstance(resolved.filter, NativeFilter):
        return _run_native(mesh_set, resolved, resolved.filter, values, meshes)
    return _run_ours(mesh_set, resolved, resolved.filter, values, progress)


def _run_ours(
    mesh_set: Any,
    resolved: ResolvedStep,
    item: Filter,
    values: Mapping[str, Any],
    progress: Progress,
) -> Ran:
    noted = noted_steps(mesh_set)
    measures = run_filter(mesh_set, item, values, progress)
    return Ran(measures, values_of_run(mesh_set, item, resolved.values, noted))


def _run_native(
    mesh_set: Any,
    resolved: ResolvedStep,
    item: NativeFilter,
    values: Mapping[str, Any],
    meshes: Collection[int],
) -> Ran:
    before = current_identifier(mesh_set)
    was_mesh = before in meshes
    reason = reason_to_skip(mesh_set, item, values)
    if reason and not was_mesh:
        message = f"{reason}; reconstruct a surface first, or run leniently to pass over it"
        raise GeometryError(message)
    noted = noted_steps(mesh_set)
    measures = apply_native(mesh_set, item.python_name, values, may_empty=was_mesh)
    if reason:
        warn_user(f"'{item.menu_name}' deleted every point: no face was left")
    parameters = values_of_run(mesh_set, item, resolved.values, noted)
    followed: dict[str, Any] = {}
    then = resolved.then
    if then is not None and mesh_set.current_mesh().face_number():
        noted = noted_steps(mesh_set)
        measures |= apply_native(mesh_set, then.python_name, then.values)
        known = values_of_run(mesh_set, find_native(then.python_name), then.values, noted)
        followed = {"filter": then.python_name, "parameters": known}
    if resolved.keeps_current and mesh_set.mesh_id_exists(before):
        mesh_set.set_current_mesh(before)
    return Ran(measures, parameters, followed)


def _identifier_at(mesh_set: Any, parameter: str, position: int) -> int:
    """Return the identifier of the layer at a position: scripts count, MeshLab numbers."""
    identifiers = [int(mesh.id()) for mesh in mesh_set]
    if position >= len(identifiers):
        message = (
            f"parameter '{parameter}' must be the position of a layer, counted from 0; "
            f"got {position}; the document has {len(identifiers)} layers at this step"
        )
        raise ParameterError(message)
    return identifiers[position]
