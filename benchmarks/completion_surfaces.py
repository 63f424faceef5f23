"""Ways from an incomplete scan to a surface, and how far each surface is from the true one.

`SURFACES` names them: ours, end to end, and what MeshLab offers for a scan with holes.  Screened
Poisson gets the normals of the same chain, all turned outward together; with *true signs* every
single normal is turned as the true surface is, which nobody could do on a real scan.
"""

from __future__ import annotations

import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import pymeshlab
from completion_measures import agreement
from completion_scans import Case
from models import Model, scan
from scipy.spatial import cKDTree

from meshlab_symrecon import SymReconWarning, apply_filter
from meshlab_symrecon.geometry.surfaces import topology
from meshlab_symrecon.host.reconstruction import whole_method

NEAR = 0.01  # diagonals
SAMPLES = 100_000  # of either surface
DEPTH = 8
OPEN = 5.0  # spacings: holes wider than this are left open before MeshLab closes them
TRIMMED = 4.0  # spacings: Poisson surface farther from the scan than this is cut off
LARGEST_HOLE = 100_000  # edges
NOTHING = (np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))

Mesh = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Nearness:
    """How near a surface is to the true one; distances in % of the diagonal."""

    mean: float  # of both directions
    hausdorff: float  # the larger direction
    f: float  # at 1 % of the diagonal
    closed: bool
    seconds: float  # CPU


def nearness(mesh: Mesh, truth, diagonal: float, seconds: float) -> Nearness:
    """Compare a mesh with dense samples of the truth (m, 3)."""
    points, faces = mesh
    if len(faces) == 0:
        return Nearness(np.inf, np.inf, 0.0, False, seconds)
    samples = scan(Model("surface", points, faces), SAMPLES, 0.0, 0.0, 0)
    truth = truth[:: max(1, len(truth) // SAMPLES)]
    there = 100 * cKDTree(truth).query(samples)[0] / diagonal
    back = 100 * cKDTree(samples).query(truth)[0] / diagonal
    return Nearness(
        mean=float(there.mean() + back.mean()) / 2,
        hausdorff=float(max(there.max(), back.max())),
        f=agreement(samples, truth, NEAR * diagonal).f,
        closed=topology(faces).closed,
        seconds=seconds,
    )


# -------------------------------------------------------------------------------------------- ways


def cloud(points) -> pymeshlab.MeshSet:
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(points))
    return mesh_set


def current(mesh_set) -> Mesh:
    mesh = mesh_set.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64)


def reconstructed(case: Case) -> Mesh:
    """What ``symrecon reconstruct`` does, from a file of the scan."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "scan.ply")
        cloud(case.points).save_current_mesh(str(path))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SymReconWarning)
            return current(
                whole_method(path, {"randomseed": 0}, lambda fraction, message: None).mesh_set
            )


def power_crust(case: Case) -> Mesh:
    """The Power Crust of the scan as it is."""
    return crust(case, widest_cap=0.0)[1]


def power_crust_closed(case: Case) -> Mesh:
    """The Power Crust with its wide holes open, then closed by MeshLab."""
    return holes_closed(crust(case, widest_cap=OPEN)[0])


def crust(case: Case, widest_cap: float) -> tuple[pymeshlab.MeshSet, Mesh]:
    mesh_set = cloud(case.points)
    name = "generate_surface_reconstruction_power_crust"
    apply_filter(mesh_set, name, widestcap=widest_cap)
    return mesh_set, current(mesh_set)


def poisson(case: Case) -> Mesh:
    """Screened Poisson of the scan."""
    return screened(case, true_signs=False)


def poisson_true_signs(case: Case) -> Mesh:
    """Screened Poisson of the scan, each normal turned as the true surface is."""
    return screened(case, true_signs=True)


def poisson_trimmed(case: Case) -> Mesh:
    """Screened Poisson with true signs, cut off away from the scan, and closed by MeshLab."""
    points, faces = screened(case, true_signs=True)
    tree = cKDTree(case.points)
    spacing = np.median(tree.query(case.points, k=5)[0][:, 1:].mean(axis=1))
    near = tree.query(points)[0] < TRIMMED * spacing
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(points, faces[near[faces].all(axis=1)]))
    mesh_set.meshing_remove_unreferenced_vertices()
    return holes_closed(mesh_set)


@lru_cache(maxsize=1)
def screened(case: Case, *, true_signs: bool) -> Mesh:
    mesh_set = cloud(case.points)
    mesh_set.compute_normal_for_point_clouds()
    normals = mesh_set.current_mesh().vertex_normal_matrix()
    nearest = cKDTree(case.surface).query(case.points)[1]
    signs = np.sign(np.einsum("ni,ni->n", normals, case.surface_normals[nearest]))
    signs = signs if true_signs else np.full(len(signs), 1.0 if signs.sum() >= 0 else -1.0)
    turned = normals * np.where(signs == 0.0, 1.0, signs)[:, np.newaxis]
    mesh_set.add_mesh(pymeshlab.Mesh(case.points, v_normals_matrix=turned))
    mesh_set.generate_surface_reconstruction_screened_poisson(depth=DEPTH, threads=1)
    return current(mesh_set)


def holes_closed(mesh_set) -> Mesh:
    """Close every hole by MeshLab's filter, which needs manifold edges."""
    mesh_set.meshing_repair_non_manifold_edges()
    mesh_set.meshing_close_holes(maxholesize=LARGEST_HOLE)
    return current(mesh_set)


SURFACES: dict[str, Callable[[Case], Mesh]] = {
    "ours": reconstructed,
    "power crust": power_crust,
    "power crust, holes closed": power_crust_closed,
    "Poisson": poisson,
    "Poisson, true signs": poisson_true_signs,
    "Poisson trimmed, holes closed": poisson_trimmed,
}


def surfaces_of(case: Case, ways=tuple(SURFACES)) -> dict[str, Nearness]:
    """Make and judge the surfaces of a scan; a way that fails has none.

    The time of the trimmed surface is without that of the Poisson surface which it starts from.
    """
    found = {}
    for way in ways:
        started = time.process_time()
        try:
            mesh = SURFACES[way](case)
        except pymeshlab.PyMeshLabException:
            mesh = NOTHING
        seconds = time.process_time() - started
        found[way] = nearness(mesh, case.truth, case.diagonal, seconds)
    return found
