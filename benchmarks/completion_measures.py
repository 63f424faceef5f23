"""Measures of a completed cloud against the true surface; lengths in % of the diagonal.

All are pure functions.  ``near`` is a distance in the units of the points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.geometry.planes import reflect

SPACING_NEIGHBOURS = 4
SEAM = 3.0  # spacings: points of the other kind as near as this make a point one of the seam
BALL = 3.0  # spacings: density is counted within
SURROUNDINGS = (6.0, 12.0)  # spacings from the seam: their balls and those of the seam are apart
COMPARED = 64  # points of the surroundings to which a point of the seam is compared
SIDE = 8  # points of each kind whose mean heights are compared across the seam
NOTHING = np.zeros((0, 3))
FEWEST = 30  # points that make a seam


@dataclass(frozen=True)
class Agreement:
    """How a cloud agrees with a surface at one distance."""

    f: float
    precision: float  # share of the cloud near the surface
    recall: float  # share of the surface near the cloud


def agreement(cloud, surface, near: float, also=NOTHING) -> Agreement:
    """Compare a cloud (n, 3) with dense samples of a surface (m, 3) at a distance.

    What is ``also`` there, (p, 3), counts for precision only.
    """
    precision = share_near(cloud, np.concatenate([surface, also]), near)
    recall = share_near(surface, cloud, near)
    total = precision + recall
    return Agreement(2 * precision * recall / total if total else 0.0, precision, recall)


def share_near(points, others, near: float) -> float:
    """Return the share of points that have one of the others nearer than a distance.

    Of removed points and a completed cloud: recall on the removed part.  Of mirrored points and
    all that is true: 1 - the share of invented ones.
    """
    if len(points) == 0 or len(others) == 0:
        return float(len(points) == 0)
    distances = cKDTree(others).query(points, distance_upper_bound=near)[0]
    return float(np.isfinite(distances).mean())


def farthest(points, others, diagonal: float) -> tuple[float, float]:
    """Return the one-sided Hausdorff distance, and the 95th percentile of the distances, in %."""
    distances = 100 * cKDTree(others).query(points)[0] / diagonal
    return float(distances.max()), float(np.quantile(distances, 0.95))


def asymmetry(surface, plane, diagonal: float, count: int = 20_000) -> tuple[float, float]:
    """Return median and 95th percentile of how far mirror images lie off a surface, in %."""
    images = reflect(surface[:count], plane)
    distances = 100 * cKDTree(surface).query(images)[0] / diagonal
    return float(np.median(distances)), float(np.quantile(distances, 0.95))


def landing(clean, removed, plane) -> tuple[np.ndarray, np.ndarray]:
    """Return what a true plane can give: the complete statue's image where the scan lacks it.

    Parameters
    ----------
    clean : (c, 3) float
        The complete statue's samples.
    removed : (c,) bool
        Which of them the scan lacks.
    plane : (4,) float

    Returns
    -------
    images : (m, 3) float
        Those whose nearest sample was removed: as dense as the scan, and nothing laid twice.
    source : (m,) int
        The samples that they are images of.
    """
    images = reflect(clean, plane)
    source = np.flatnonzero(removed[cKDTree(clean).query(images)[1]])
    return images[source], source


def normal_angles(points, normals, surface, surface_normals) -> tuple[float, float]:
    """Return median angles in degrees to the surface's normals: as lines, and as directions."""
    if len(points) == 0:
        return np.nan, np.nan
    true = surface_normals[cKDTree(surface).query(points)[1]]
    lengths = np.linalg.norm(normals, axis=1) * np.linalg.norm(true, axis=1)
    cosines = np.einsum("ni,ni->n", normals, true) / np.maximum(lengths, 1e-300)
    lines = np.degrees(np.arccos(np.minimum(np.abs(cosines), 1.0)))
    directions = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
    return float(np.median(lines)), float(np.median(directions))


def mean_spacing(points) -> float:
    """Return the median over the points of the mean distance to the 4 nearest others."""
    distances = cKDTree(points).query(points, k=SPACING_NEIGHBOURS + 1)[0][:, 1:]
    return float(np.median(distances.mean(axis=1)))


def seam_of(cloud, mirrored, spacing: float) -> np.ndarray:
    """Tell which points have one of the other kind within 3 spacings, (n,) bool."""
    seam = np.zeros(len(cloud), dtype=bool)
    if mirrored.any() and not mirrored.all():
        for kind in (mirrored, ~mirrored):
            limit = SEAM * spacing
            gaps = cKDTree(cloud[~kind]).query(cloud[kind], distance_upper_bound=limit)[0]
            seam[kind] = np.isfinite(gaps)
    return seam


def seam_ratios(cloud, seam, spacing: float) -> np.ndarray:
    """Return the spacing at each point of a seam / the mean spacing of its surroundings, (s,).

    The spacing is that of the density in a ball of 3 spacings.  The surroundings are the 64 nearest
    points that lie 6 to 12 spacings from the seam, on either side of it.
    """
    tree = cKDTree(cloud)
    gaps = cKDTree(cloud[seam]).query(cloud)[0] / spacing
    around = cloud[(gaps >= SURROUNDINGS[0]) & (gaps <= SURROUNDINGS[1])]
    if len(around) < COMPARED:
        return np.full(seam.sum(), np.nan)
    at, beside = (
        tree.query_ball_point(places, BALL * spacing, return_length=True) ** -0.5
        for places in (cloud[seam], around)
    )
    nearest = cKDTree(around).query(cloud[seam], k=COMPARED)[1]
    return at / beside[nearest].mean(axis=1)


@dataclass(frozen=True)
class Seam:
    """How the mirrored points join the measured ones."""

    spacing: float = np.nan  # median of the ratios / that of the complete cloud at the same places
    off: float = np.nan  # share of ratios out by more than 25 %
    own_off: float = np.nan  # the same of the complete cloud
    step: float = np.nan  # rms height of one side over the other, % of the diagonal
    own_step: float = np.nan  # the same of the complete cloud, parted at the same places
    roughness: float = np.nan  # rms height of mirrored points at the seam / farther away


def seam_quality(cloud, mirrored, sampled, heights, own_heights, diagonal: float) -> Seam:
    """Compare a seam with its surroundings, and with the complete cloud at the same places.

    Parameters
    ----------
    cloud : (n, 3) float
        The completed cloud.
    mirrored : (n,) bool
    sampled : (c, 3) float
        The complete cloud, before anything was removed.
    heights, own_heights : (n,), (c,) float
        Heights of both clouds' points over the true surface.
    diagonal : float
    """
    spacing = mean_spacing(sampled)
    seam = seam_of(cloud, mirrored, spacing)
    if seam.sum() < FEWEST:
        return Seam()
    nearest = cKDTree(cloud).query(sampled)[1]
    own_mirrored, own_seam = mirrored[nearest], seam[nearest]
    ratios = seam_ratios(cloud, seam, spacing)
    own_ratios = seam_ratios(sampled, own_seam, spacing)
    rough = rms(heights[beyond_surroundings(cloud, seam, spacing) & mirrored])
    return Seam(
        spacing=float(np.median(ratios) / np.median(own_ratios)),
        off=float((np.abs(ratios - 1.0) > 0.25).mean()),
        own_off=float((np.abs(own_ratios - 1.0) > 0.25).mean()),
        step=100 * step(cloud, mirrored, seam, heights) / diagonal,
        own_step=100 * step(sampled, own_mirrored, own_seam, own_heights) / diagonal,
        roughness=rms(heights[seam & mirrored]) / rough if rough > 0.0 else np.nan,
    )


def beyond_surroundings(cloud, seam, spacing: float) -> np.ndarray:
    """Tell which points lie beyond the surroundings of a seam, (n,) bool."""
    return cKDTree(cloud[seam]).query(cloud)[0] > SURROUNDINGS[1] * spacing


def step(cloud, mirrored, seam, heights) -> float:
    """Return the rms of: mean height of the 8 nearest mirrored - of the 8 nearest measured."""
    if min(mirrored.sum(), (~mirrored).sum()) < SIDE:
        return np.nan
    sides = [
        heights[kind][cKDTree(cloud[kind]).query(cloud[seam], k=SIDE)[1]].mean(axis=1)
        for kind in (mirrored, ~mirrored)
    ]
    return rms(sides[0] - sides[1])


def heights_over(points, surface, surface_normals, within: float = np.inf) -> np.ndarray:
    """Return heights over a surface along the normal of its nearest sample, (n,).

    NaN for points that are not ``within`` a distance of the surface.
    """
    distances, nearest = cKDTree(surface).query(points, distance_upper_bound=within)
    heights = np.full(len(points), np.nan)
    near = np.isfinite(distances)
    gaps = points[near] - surface[nearest[near]]
    heights[near] = np.einsum("ni,ni->n", gaps, surface_normals[nearest[near]])
    return heights


def rms(values) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else np.nan
