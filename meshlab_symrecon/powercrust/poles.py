"""Poles: the Voronoi vertices that carry the shape (Amenta, Choi, Kolluri 2001, section 2)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from meshlab_symrecon import _native
from meshlab_symrecon.arrays import Booleans, Floats, Indices, Points
from meshlab_symrecon.geometry.triangulation import Triangulation

__all__ = ["CUBE", "ENCLOSURE", "Poles", "enclose", "find_poles"]

FLAT = 1e-12  # of the spread of the poles
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
ENCLOSURE = 4.0  # half side of the enclosing cube / longest extent, as in the original


@dataclass(frozen=True, slots=True, eq=False)
class Poles:
    """Poles of samples, each once, with its polar ball.

    Attributes
    ----------
    sites : (n + 8, 3) float
        The samples, then the corners of the enclosing cube.
    centres : (p, 3) float
    radii : (p,) float
        Distance of a pole to the samples that it belongs to.
    samples : (p, 4) int
        The samples on the polar ball; numbers from the count of samples on are enclosing corners.
    pairs : (k, 2) int
        The two poles of a sample, the farther one first; samples merged into others have none.
    pair_samples : (k,) int
        The sample of each pair.
    outermost : (p,) bool
        Poles whose ball touches a corner of the enclosing cube, or whose centre lies outside a
        polytope round the samples: certainly outside, since no inner ball is centred there.
    spacing : (n,) float
        Distance of each sample to the next one.
    room : (n,) float
        Mean distance of each sample to the four nearest of its Delaunay neighbours, or to three
        where the fourth is on another side of the body.
    """

    sites: Points
    centres: Points
    radii: Floats
    samples: Indices
    pairs: Indices
    pair_samples: Indices
    outermost: Booleans
    spacing: Floats
    room: Floats

    @property
    def sample_count(self) -> int:
        """Number of samples: the sites before the corners."""
        return len(self.sites) - len(CUBE)

    @property
    def rank(self) -> int:
        """Dimensions that the poles span; below 3 for a handful of cospherical samples."""
        spread = np.linalg.svd(self.centres - self.centres.mean(axis=0), compute_uv=False)
        return int(np.count_nonzero(spread > FLAT * spread[0]))

    def only(self, kept: Booleans, pairs: Indices, pair_samples: Indices) -> Poles:
        """Return some of the poles, (p,) True for those, with new pairs of them."""
        return replace(
            self,
            centres=self.centres[kept],
            radii=self.radii[kept],
            samples=self.samples[kept],
            pairs=pairs,
            pair_samples=pair_samples,
            outermost=self.outermost[kept],
        )


def enclose(samples: Points) -> Points:
    """Return the samples followed by the eight corners of a cube far round them.

    The corners bound the Voronoi cell of every sample.  The cube stands along the samples'
    principal axes, so that the poles turn with the samples.

    Parameters
    ----------
    samples : (n, 3) float

    Returns
    -------
    (n + 8, 3) float
    """
    mean = samples.mean(axis=0)
    axes = np.linalg.eigh(np.cov((samples - mean).T))[1]
    along = (samples - mean) @ axes
    low, high = along.min(axis=0), along.max(axis=0)
    half = ENCLOSURE * float((high - low).max())
    corners = mean + (0.5 * (low + high) + half * CUBE) @ axes.T
    return np.concatenate([samples, corners])


def _beyond(centres: Points, sites: Points, sample_count: int) -> Booleans:
    """Return (p,) True for centres outside the samples' extent in one of 13 directions.

    The directions are the faces, edges and corners of the enclosing cube.
    """
    samples, corners = sites[:sample_count], sites[sample_count:]
    axes = corners[[4, 2, 1]] - corners[0]  # CUBE counts x, y, z in binary
    steps = np.stack(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3), axis=-1).reshape(-1, 3)[:13]
    directions = steps @ axes  # the other half points the other way
    beyond = np.zeros(len(centres), dtype=bool)
    for direction in directions:
        height, extent = centres @ direction, samples @ direction
        beyond |= (height < extent.min()) | (height > extent.max())
    return beyond


def find_poles(delaunay: Triangulation, sample_count: int) -> Poles:
    """Find the two poles of every sample.

    The first pole of a sample s is the vertex of its Voronoi cell farthest from s; the second is
    the farthest one, v, on the other side: (v - s) . (first - s) <= 0.

    Parameters
    ----------
    delaunay : Triangulation
        Delaunay triangulation of ``enclose(samples)``.
    sample_count : int
        Number of samples; the sites after them are the corners.
    """
    cells, centres, first, second, spacing, room = _native.find_poles(
        delaunay.sites, delaunay.cells, sample_count
    )
    paired = np.flatnonzero(second >= 0)
    samples = delaunay.cells[cells].astype(np.int64)
    arms = centres - delaunay.sites[samples[:, 0]]
    return Poles(
        sites=delaunay.sites,
        centres=centres,
        radii=np.linalg.norm(arms, axis=1),
        samples=samples,
        pairs=np.stack([first[paired], second[paired]], axis=1).astype(np.int64),
        pair_samples=paired,
        outermost=(samples >= sample_count).any(axis=1)
        | _beyond(centres, delaunay.sites, sample_count),
        spacing=spacing,
        room=room,
    )
