"""Defaults of MeshLab's filters that are the same whatever layer the filter works on.

pymeshlab tells defaults for one layer at a time, and many depend on its size, its number of faces
or its selection. Those that are equal on two layers which differ in all of this are constant.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pymeshlab

from meshlab_symrecon.host.native_filters import NativeFilter, native_filters
from meshlab_symrecon.host.native_values import NativeParameter, checked_value
from meshlab_symrecon.host.remembered import first_defaults

__all__ = ["constant_defaults"]

FROM_THE_DOCUMENT = ("RichMesh", "RichShotf")  # a layer's number; a camera
FROM_THE_MACHINE = ("threads",)


def constant_defaults(python_name: str) -> Mapping[str, Any]:
    """Return the defaults of a filter that depend neither on the layer nor on the machine."""
    return _of_all_filters()[python_name]


@cache
def _of_all_filters() -> Mapping[str, Mapping[str, Any]]:
    """Ask for all filters at once, so that no document outlives the question."""
    first, second = _unlike()
    return {
        name: _constant(item, *(one.filter_parameter_values(name) for one in (first, second)))
        for name, item in native_filters().items()
    }


def _constant(
    item: NativeFilter, first: Mapping[str, Any], second: Mapping[str, Any]
) -> Mapping[str, Any]:
    kept = first_defaults(item.python_name)
    return {
        known.name: checked_value(known, first[known.name])
        for known in _asked(item)
        if np.array_equal(_plain(first[known.name]), _plain(second[known.name]))
    } | {name: checked_value(item.find(name), value) for name, value in kept.items()}


def _asked(item: NativeFilter) -> tuple[NativeParameter, ...]:
    return tuple(
        known
        for known in item.parameters
        if known.rich_type not in FROM_THE_DOCUMENT and known.name not in FROM_THE_MACHINE
    )


def _plain(value: Any) -> Any:
    if isinstance(value, pymeshlab.Color):
        return (value.red(), value.green(), value.blue(), value.alpha())
    return value


def _unlike() -> tuple[Any, Any]:
    """Return two documents that differ in name, size, counts, quality, selection and matrix."""
    small, large = (pymeshlab.MeshSet(verbose=False) for _ in range(2))
    small.create_sphere(subdiv=2)
    small.compute_scalar_by_function_per_face(q="x0")
    large.create_cube(size=7.0)
    large.compute_color_by_function_per_vertex(x="1", y="2", z="x*9")
    large.compute_scalar_by_function_per_vertex(q="x")
    large.compute_scalar_by_function_per_face(q="x0+1")
    large.set_selection_all()
    large.compute_texcoord_parametrization_triangle_trivial_per_wedge()
    large.compute_matrix_from_translation(axisx=3.0, freeze=False)
    return small, large
