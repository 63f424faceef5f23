"""Where the two sides of a statue differ, and what that tells about the side that is missing.

No statue is its own exact mirror image: it bends, leans and was carved by hand. Where both sides
were measured, the offset from each mirror image to the measured surface is known; into a hole it
is carried by kriging (Matheron 1969; Cressie 1993, *Statistics for Spatial Data*, section 3.4).
How far it carries is read from the statue itself, from how alike the offsets of neighbouring
places are: where they are not alike, as those of noise, nothing is carried.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import nnls
from scipy.spatial import cKDTree

from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points
from meshlab_symrecon.geometry.planes import reflect, reflect_directions
from meshlab_symrecon.geometry.sampling import farthest_point_order
from meshlab_symrecon.symmetry.preparation import PreparedCloud

__all__ = ["AsymmetryField", "asymmetry_field"]

# Lengths are in diagonals of the prepared cloud.
REACH = 0.05  # mirror images farther from the surface show a missing part, not an offset
LEAST_COSINE = 0.7  # between the normals of an image and of the surface it belongs to
BESIDE = 1.5  # spacings along the surface between an image and its partner
BESIDE_SLOPE = 0.3  # and this share of the height between them
LENGTHS = (0.03, 0.06, 0.12, 0.25, 0.5, 1.0)  # correlation lengths that are mixed
SHORTEST = 1e-6  # of them: nothing is carried as far as that
LAGS = np.append(0.0, np.geomspace(0.01, 1.0, 24))  # bounds of the classes of distance
NEAR_PAIRS, FAR_PAIRS = 16, 40  # partners of a place in the estimate of the correlation
FEWEST_PAIRS = 50  # in a class of distance
FEWEST_PLACES = 100  # where both sides were measured
MOST_PLACES = 1_200  # even samples of them that are kriged
DRIFT = 0.02  # radians: standard deviation of a turn of one side against the other, before looking
DRIFT_SHIFT = 0.006  # diagonals: and of its shift
AGREEING = 13  # places, the one itself among them, whose offsets are compared
RETURN, RETURN_SLOPE = 2.0, 0.5  # the same of a place and the partner of its partner
DOUBT = 0.1  # share of an offset by which it may be wrong
LEAST_NOISE = 0.1  # spacings
FAR_OFF = 12.0  # usual sizes of the offsets beyond a rigid motion: what is farther is disbelieved
DISBELIEF = 3.0  # times what lies beyond
REWEIGHTED = 20  # times at most
SPEAKING = 200  # places whose offsets say as much as those of all, since neighbours are alike
TINY = float(np.finfo(np.float64).tiny)
BLOCK = 4_096  # places at a time


@dataclass(frozen=True, slots=True, eq=False)
class AsymmetryField:
    """Offsets of mirror images, in the frame of the prepared cloud they were seen on."""

    cloud: PreparedCloud
    places: Points  # (m, 3)  mirror images
    pulls: Points  # (m, 3)  weights of the offsets seen there, along the surface's normals
    variances: Floats  # (l,)  of each correlation length
    lengths: Floats  # (l,)
    drift: Floats  # (6,)  shift and turn of the whole

    def offsets(self, images: Points) -> Points:
        """Return how far mirror images are expected to lie off the true surface.

        Parameters
        ----------
        images : (n, 3) float
            In the coordinates of the scan.

        Returns
        -------
        (n, 3) float
            To be added to the images, in the units of the scan.
        """
        framed = (images - self.cloud.centre) @ self.cloud.axes.T / self.cloud.scale
        moves = np.empty_like(framed)
        for start in range(0, len(framed), BLOCK):
            block = framed[start : start + BLOCK]
            moves[start : start + BLOCK] = (
                _covariances(block, self.places, self.variances, self.lengths) @ self.pulls
            )
        moves += _rigid_motions(framed) @ self.drift
        offsets: Points = moves @ self.cloud.axes * self.cloud.scale
        return offsets


def asymmetry_field(cloud: PreparedCloud, plane: Floats, longest: float) -> AsymmetryField | None:
    """Estimate the offsets between the mirror images of a cloud and its surface.

    Parameters
    ----------
    cloud : PreparedCloud
        The scan.
    plane : (4,) float
        The mirror plane, in the coordinates of the scan.
    longest : float
        Longest correlation length that is used, in diagonals.

    Returns
    -------
    AsymmetryField or None
        None where too little was measured on both sides.
    """
    images, normals, heights, seen = _seen_offsets(cloud, cloud.from_input(plane[np.newaxis])[0])
    both = np.flatnonzero(seen)
    if len(both) < FEWEST_PLACES:
        return None
    lengths = np.array(
        [length for length in LENGTHS if length <= longest] or [max(longest, SHORTEST)]
    )
    images, normals, heights = images[both], normals[both], heights[both]
    trend, scale = _trend(images, normals, heights, LEAST_NOISE * cloud.spacing)
    believed = trend + np.clip(heights - trend, -FAR_OFF * scale, FAR_OFF * scale)
    variances, noise = _correlation(images, normals, believed, lengths)
    noise = max(noise, (LEAST_NOISE * cloud.spacing) ** 2, (0.5 * cloud.roughness) ** 2)
    doubts = np.hypot(_doubts(images, normals, heights), DISBELIEF * (heights - believed))
    even = farthest_point_order(images, MOST_PLACES)
    places, upright, heights = images[even], normals[even], heights[even]
    prior = np.repeat([DRIFT_SHIFT**2, DRIFT**2], 3)
    turns = np.einsum("mik,mi->mk", _rigid_motions(places), upright)
    covariances = _covariances(places, places, variances, lengths) * (upright @ upright.T)
    covariances += (turns * prior) @ turns.T
    covariances[np.diag_indices(len(places))] += noise + doubts[even] ** 2
    weights = cho_solve(cho_factor(covariances), heights)
    return AsymmetryField(
        cloud=cloud,
        places=places,
        pulls=weights[:, np.newaxis] * upright,
        variances=variances,
        lengths=lengths,
        drift=prior * (turns.T @ weights),
    )


def _seen_offsets(cloud: PreparedCloud, plane: Floats) -> tuple[Points, Points, Floats, Booleans]:
    """Return the mirror images, normals there, and the heights of the surface above them.

    Along the surface, samples differ by chance, so that only the height counts; beyond the rim of
    a hole there is none. Partners are mutual: an image in a hole may lie near another part of the
    statue, but that has its own partner elsewhere.
    """
    images = reflect(cloud.points, plane)
    distances, nearest = cKDTree(cloud.points).query(images)
    turned, theirs = reflect_directions(cloud.normals, plane), cloud.normals[nearest]
    facing = np.einsum("ni,ni->n", turned, theirs)
    known = cloud.oriented & cloud.oriented[nearest]
    seen = np.where(known, facing, np.abs(facing)) > LEAST_COSINE
    # Two points of one sphere are at one height along the mean of their normals.
    normals = theirs + turned * np.sign(facing)[:, np.newaxis]
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), TINY)
    heights = np.einsum("ni,ni->n", cloud.points[nearest] - images, normals)
    beside = np.sqrt(np.maximum(distances**2 - heights**2, 0.0))
    seen &= distances < REACH
    seen &= beside < BESIDE * cloud.spacing + BESIDE_SLOPE * np.abs(heights)
    astray = np.linalg.norm(cloud.points[nearest[nearest]] - cloud.points, axis=1)
    seen &= astray < RETURN * cloud.spacing + RETURN_SLOPE * np.abs(heights)
    return images, normals, heights, seen & ~cloud.border[nearest]


def _trend(places: Points, normals: Points, heights: Floats, least: float) -> tuple[Floats, float]:
    """Return what a rigid motion explains of the offsets, and the usual size of the rest.

    By iterated reweighting with Tukey's biweight (Beaton and Tukey 1974): where a limb is missing,
    the other one's image may pair with the limb itself, a whole patch of offsets that agree.
    """
    turns = np.einsum("mik,mi->mk", _rigid_motions(places), normals)
    stiffness = np.diag(np.repeat([DRIFT_SHIFT**-2, DRIFT**-2], 3))
    drift = np.zeros(6)
    for _ in range(REWEIGHTED):
        rest = heights - turns @ drift
        scale = max(1.4826 * float(np.median(np.abs(rest))), least)
        weights = (1.0 - np.minimum(np.abs(rest) / (FAR_OFF * scale), 1.0) ** 2) ** 2
        weighted = turns.T * (weights * SPEAKING / (len(rest) * scale**2))
        before, drift = drift, np.linalg.solve(weighted @ turns + stiffness, weighted @ heights)
        if np.abs(drift - before).max() < 1e-7:
            break
    trend = turns @ drift
    return trend, max(1.4826 * float(np.median(np.abs(heights - trend))), least)


def _doubts(places: Points, normals: Points, heights: Floats) -> Floats:
    """Return by how much each offset may be wrong.

    Clutter and false partners differ from those round them; and the larger an offset, the likelier
    it is a false one.
    """
    around = cKDTree(places).query(places, k=AGREEING)[1]
    alike = np.einsum("nki,ni->nk", normals[around], normals) > LEAST_COSINE
    usual = np.nanmedian(np.where(alike, heights[around], np.nan), axis=1)
    doubts: Floats = np.hypot(heights - usual, DOUBT * heights)
    return doubts


def _correlation(
    places: Points, normals: Points, heights: Floats, lengths: Floats
) -> tuple[Floats, float]:
    """Fit the variance of each correlation length, and of what is not correlated.

    Heights along two normals are as alike as the offsets times the cosine between the normals.
    """
    first, second = _pairs(places)
    distances = np.linalg.norm(places[first] - places[second], axis=1)
    cosines = np.einsum("pi,pi->p", normals[first], normals[second])
    lags = np.digitize(distances, LAGS) - 1
    total = len(LAGS)
    counts = np.bincount(lags, minlength=total)
    weights = np.bincount(lags, cosines**2, total)
    used = (counts >= FEWEST_PAIRS) & (weights > 0.0)
    products = np.bincount(lags, heights[first] * heights[second] * cosines, total)
    rows = [
        np.bincount(lags, np.exp(-distances / length) * cosines**2, total)[used] / weights[used]
        for length in lengths
    ]
    variances: Floats = nnls(np.stack(rows, axis=1), products[used] / weights[used])[0]
    return variances, float((heights**2).mean() - variances.sum())


def _pairs(places: Points) -> tuple[Indices, Indices]:
    """Return pairs of places: each with its neighbours, and with some at every distance."""
    count = len(places)
    nearest = min(NEAR_PAIRS + 1, count)
    near = cKDTree(places).query(places, k=nearest)[1][:, 1:]
    far = np.random.default_rng(0).integers(0, count, (count, FAR_PAIRS))
    second = np.concatenate([near, far], axis=1)
    first = np.repeat(np.arange(count), second.shape[1])
    apart = first != second.ravel()
    return first[apart], second.ravel()[apart]


def _covariances(images: Points, places: Points, variances: Floats, lengths: Floats) -> Floats:
    """Return the covariances of offsets at images (n, 3) and places (m, 3): (n, m)."""
    squares = (images**2).sum(axis=1)[:, np.newaxis] + (places**2).sum(axis=1)
    distances = np.sqrt(np.maximum(squares - 2.0 * images @ places.T, 0.0))
    summed: Floats = np.zeros_like(distances)
    for variance, length in zip(variances, lengths, strict=True):
        if variance > 0.0:
            summed += variance * np.exp(distances / -length)
    return summed


def _rigid_motions(places: Points) -> Floats:
    """Return how the three shifts and three small turns move each place: (n, 3, 6)."""
    motions = np.zeros((len(places), 3, 6))
    motions[:, [0, 1, 2], [0, 1, 2]] = 1.0
    x, y, z = places.T
    motions[:, 1, 3], motions[:, 2, 3] = -z, y
    motions[:, 0, 4], motions[:, 2, 4] = z, -x
    motions[:, 0, 5], motions[:, 1, 5] = -y, x
    return motions
