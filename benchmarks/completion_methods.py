"""Ways to complete a scan, through the filters as the documented chain calls them."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass

import numpy as np
import pymeshlab

from meshlab_symrecon import SymReconWarning, apply_filter
from meshlab_symrecon.geometry.plane_quads import planes_as_quads
from meshlab_symrecon.geometry.planes import reflect, reflect_directions


@dataclass(frozen=True, slots=True, eq=False)
class Completed:
    """A completed cloud."""

    points: np.ndarray  # (n + m, 3)
    normals: np.ndarray  # (n + m, 3)
    mirrored: np.ndarray  # (n + m,) bool
    planes: np.ndarray  # (k, 4)  used
    seconds: float = 0.0  # CPU time of the completion alone


def ours(points, planes=None, **settings) -> Completed:
    """Complete across detected planes or given ones; ``settings`` are the filter's parameters."""
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(points))
    mesh_set.compute_normal_for_point_clouds()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SymReconWarning)
        if planes is None:
            planes = apply_filter(mesh_set, "generate_reflection_planes")["planes"]
        else:
            mesh_set.add_mesh(pymeshlab.Mesh(*planes_as_quads(planes, points)), "reflection planes")
            mesh_set.set_current_mesh(0)
        started = time.process_time()
        apply_filter(mesh_set, "generate_mirror_completed_points", **settings)
        seconds = time.process_time() - started
    mesh = mesh_set.current_mesh()
    mirrored = np.arange(mesh.vertex_number()) >= len(points)
    return Completed(mesh.vertex_matrix(), mesh.vertex_normal_matrix(), mirrored, planes, seconds)


def whole_mirror(done: Completed) -> Completed:
    """Add the whole measured cloud's image across the first plane that ours has used."""
    points, normals = done.points[~done.mirrored], done.normals[~done.mirrored]
    if len(done.planes) == 0:
        return nothing(done)
    plane = done.planes[0]
    return Completed(
        np.concatenate([points, reflect(points, plane)]),
        np.concatenate([normals, reflect_directions(normals, plane)]),
        np.arange(2 * len(points)) >= len(points),
        done.planes[:1],
    )


def nothing(done: Completed) -> Completed:
    """Leave the measured cloud as it is."""
    measured = ~done.mirrored
    return Completed(
        done.points[measured], done.normals[measured], np.zeros(measured.sum(), bool), done.planes
    )
