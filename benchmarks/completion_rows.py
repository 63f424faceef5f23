"""One row of the benchmark of completion: all that is measured of one scan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from completion_measures import (
    Seam,
    agreement,
    asymmetry,
    farthest,
    heights_over,
    landing,
    normal_angles,
    seam_quality,
    share_near,
)
from completion_methods import Completed, nothing, whole_mirror
from completion_scans import Case
from scipy.spatial import cKDTree

from meshlab_symrecon.geometry.planes import reflect, reflect_directions

NEAR = 0.01  # diagonals
OFF = 0.03  # diagonals: what lies farther from the statue is no part of its seam


@dataclass(frozen=True)
class Filled:
    """What a cloud says of the statue; distances in % of the diagonal."""

    f: float  # of the cloud without the scan's own outliers
    precision: float  # near the statue or its plinth
    recall: float  # of the statue
    missing: float  # recall on the removed part
    hausdorff: float  # from the removed part to the cloud
    hausdorff95: float
    invented: float  # share of mirrored points that are near nothing


@dataclass(frozen=True)
class Row:
    """What was measured of one scan; lengths in % of the diagonal, angles in degrees."""

    model: str
    condition: str
    seed: int
    planes: int  # used
    plane: tuple[float, float]  # angle and offset of the first from the nearest true one
    asymmetric: tuple[float, float]  # median, 95 % of the distances of the statue's mirror images
    done: Filled
    best: Filled  # what the true plane can give
    reachable: float  # share of the removed part that the scan's image at a true plane is near
    before: Filled
    whole: Filled  # the whole mirror added
    angle: float  # of mirrored normals
    directed: float  # turned all together, should the scan's be inward
    own_angle: float  # of the scan's normals
    best_angle: float  # of the complete statue's image across the true plane
    outward: bool  # whether the scan's are
    seam: Seam
    images_of: tuple[float, float]  # shares: invented images of strays, and of the plinth
    share: float  # mirrored points / removed ones
    seconds: float  # CPU, of the completion


def row_of(names: tuple[str, str, int], case: Case, done: Completed) -> Row:
    """Measure a completion of a scan; ``names`` are its model, condition and seed."""
    best, best_angle = max(
        (best_of(case, plane) for plane in case.planes), key=lambda one: one[0].f
    )
    gaps = [asymmetry(case.surface, plane, case.diagonal) for plane in case.planes]
    mirrored = done.mirrored
    truth = (case.surface, case.surface_normals)
    own = normal_angles(
        done.points[~mirrored][~case.stray], done.normals[~mirrored][~case.stray], *truth
    )
    sign = 1.0 if own[1] < 90.0 else -1.0
    angles = normal_angles(done.points[mirrored], sign * done.normals[mirrored], *truth)
    return Row(
        *names,
        planes=len(done.planes),
        plane=plane_error(case, done.planes),
        asymmetric=min(gaps),
        done=filled(case, done.points, mirrored),
        best=best,
        reachable=max(reachable(case, plane) for plane in case.planes),
        before=filled(case, *cloud_of(nothing(done))),
        whole=filled(case, *cloud_of(whole_mirror(done))),
        angle=angles[0],
        directed=angles[1],
        own_angle=own[0],
        best_angle=best_angle,
        outward=sign > 0.0,
        seam=seam_at_statue(case, done),
        images_of=images_of(case, done),
        share=mirrored.sum() / max(1, case.removed.sum()),
        seconds=done.seconds,
    )


def cloud_of(done: Completed) -> tuple[np.ndarray, np.ndarray]:
    """Return what is judged of a completion."""
    return done.points, done.mirrored


def filled(case: Case, points, mirrored) -> Filled:
    """Judge a cloud; the measured points come first, as the scan has them."""
    near = NEAR * case.diagonal
    judged = np.ones(len(points), dtype=bool)
    judged[: len(case.points)] = ~case.stray
    quality = agreement(points[judged], case.surface, near, also=case.plinth)
    hausdorff, most = farthest(case.missing, points, case.diagonal)
    return Filled(
        quality.f,
        quality.precision,
        quality.recall,
        share_near(case.missing, points, near),
        hausdorff,
        most,
        1.0 - share_near(points[mirrored], case.truth, near),
    )


def seam_at_statue(case: Case, done: Completed) -> Seam:
    """Judge the seam on the statue, clutter left out."""
    truth = (case.surface, case.surface_normals, OFF * case.diagonal)
    heights = heights_over(done.points, *truth)
    judged = np.isfinite(heights)
    judged[: len(case.points)] &= ~case.stray
    return seam_quality(
        done.points[judged],
        done.mirrored[judged],
        case.sampled,
        heights[judged],
        heights_over(case.sampled, *truth),
        case.diagonal,
    )


def images_of(case: Case, done: Completed) -> tuple[float, float]:
    """Return the shares of mirrored points that are near nothing, and images of clutter.

    The first, of strays; the second, of the plinth.  An image is that of the measured point nearest
    to its own mirror image across one of the planes.
    """
    images = done.points[done.mirrored]
    tree = cKDTree(case.truth)
    far = np.isinf(tree.query(images, distance_upper_bound=NEAR * case.diagonal)[0])
    if not far.any():
        return 0.0, 0.0
    measured = cKDTree(case.points)
    found = [measured.query(reflect(images[far], plane)) for plane in done.planes]
    gaps, sources = (np.stack(part) for part in zip(*found, strict=True))
    source = sources[np.argmin(gaps, axis=0), np.arange(far.sum())]
    stray = case.stray[source]
    base = ~stray & (tree.query(case.points[source])[1] >= len(case.surface))
    return stray.sum() / len(images), base.sum() / len(images)


def best_of(case: Case, plane) -> tuple[Filled, float]:
    """Judge what a true plane can give, and the median angle of its normals."""
    images, source = landing(case.clean, case.removed, plane)
    normals = reflect_directions(case.clean_normals[source], plane)
    points = np.concatenate([case.points, images])
    judged = filled(case, points, np.arange(len(points)) >= len(case.points))
    return judged, normal_angles(images, normals, case.surface, case.surface_normals)[0]


def reachable(case: Case, plane) -> float:
    """Return the recall on the removed part of the scan and its image across a true plane."""
    statue = case.points[~case.stray]
    both = np.concatenate([statue, reflect(statue, plane)])
    return share_near(case.missing, both, NEAR * case.diagonal)


def plane_error(case: Case, planes) -> tuple[float, float]:
    """Return the first plane's angle and offset, at the centre, from the nearest true plane."""
    if len(planes) == 0:
        return np.nan, np.nan
    found = planes[0]
    cosines = case.planes[:, :3] @ found[:3]
    angles = np.degrees(np.arccos(np.minimum(np.abs(cosines), 1.0)))
    heights = case.planes[:, :3] @ case.centre + case.planes[:, 3]
    own = found[:3] @ case.centre + found[3]
    offsets = np.abs(np.where(cosines < 0.0, -1.0, 1.0) * heights - own) / case.diagonal
    nearest = int(np.argmin(angles / 3.0 + 100 * offsets / 2.0))
    return float(angles[nearest]), 100 * float(offsets[nearest])
