"""Damaged scans together with everything that is true of them, to judge a completion by."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from damage import Damage, plinth, remaining, side_plane, stray
from scipy.spatial.transform import Rotation
from shape_surfaces import Shape

SURFACE = 200_000  # reference samples, about .2 % of the diagonal apart

CONDITIONS = {
    "region": Damage(),
    "occlusion": Damage(removal="occlusion"),
    "cut": Damage(removal="cut", share=0.3),
    "blobs": Damage(blobs=3),
    "noise": Damage(noise=0.5),
    "clutter": Damage(outliers=0.1, plinth=True),
}


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A scan and its truth."""

    points: np.ndarray  # (n, 3)  the scan
    stray: np.ndarray  # (n,) bool  its points that are outliers
    sampled: np.ndarray  # (c, 3)  the statue's samples before the damage, with their noise
    clean: np.ndarray  # (c, 3)  the same without noise
    clean_normals: np.ndarray  # (c, 3)  outward
    removed: np.ndarray  # (c,) bool
    surface: np.ndarray  # (m, 3)  dense samples of the statue
    surface_normals: np.ndarray  # (m, 3)  outward
    plinth: np.ndarray  # (p, 3)  dense samples of the plinth; none without
    planes: np.ndarray  # (k, 4)  true ones
    centre: np.ndarray  # (3,)  of the statue's box
    diagonal: float

    @property
    def missing(self) -> np.ndarray:
        """The removed part, (r, 3)."""
        return self.clean[self.removed]

    @property
    def truth(self) -> np.ndarray:
        """Dense samples of all that is there, (m + p, 3)."""
        return np.concatenate([self.surface, self.plinth])


def case_of(shape: Shape, damage: Damage, seed: int) -> Case:
    """Return a scan of a shape in a random pose; the same for the same seed."""
    rng = np.random.default_rng([seed, sum(shape.name.encode())])
    low, high = shape.box
    diagonal = float(np.linalg.norm(high - low))
    shape, centre, diagonal = posed(shape, (low + high) / 2, diagonal, rng)
    surface, surface_normals = shape.sample(SURFACE, np.random.default_rng(0))
    inside_out = np.einsum("ni,ni->", surface - centre, surface_normals) < 0.0
    surface_normals = -surface_normals if inside_out else surface_normals

    clean, normals = shape.sample(damage.count, rng)
    sampled = clean + damage.noise / 100 * diagonal * rng.normal(size=(len(clean), 1)) * normals
    plane = side_plane(shape, centre, rng)
    kept = remaining(clean, normals, plane, damage, (shape, centre, diagonal), rng)
    parts, base = [sampled[kept]], np.zeros((0, 3))
    if damage.plinth:
        start = int(rng.integers(2**31))  # the same box, once as scanned and once densely
        spread = damage.noise / 100 * diagonal
        parts.append(plinth(clean, shape, np.random.default_rng(start), spread))
        base = plinth(surface, shape, np.random.default_rng(start), 0.0)
    strays = round(damage.outliers * len(clean))
    parts.append(stray(np.concatenate(parts), strays, rng))
    scan = np.concatenate(parts)
    order = rng.permutation(len(scan))
    return Case(
        points=scan[order],
        stray=order >= len(scan) - strays,
        sampled=sampled,
        clean=clean,
        clean_normals=-normals if inside_out else normals,
        removed=~kept,
        surface=surface,
        surface_normals=surface_normals,
        plinth=base,
        planes=shape.planes,
        centre=centre,
        diagonal=diagonal,
    )


def posed(shape: Shape, centre, diagonal: float, rng) -> tuple[Shape, np.ndarray, float]:
    """Turn, scale and move a shape; return also its centre and its diagonal as they are then."""
    turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    scale = float(np.exp(rng.normal()))
    shift = scale * diagonal * rng.normal(size=3)

    def moved(places):
        return scale * places @ turn.T + shift

    def hidden(places):
        return shape.hidden((places - shift) @ turn / scale)

    normals = shape.planes[:, :3] @ turn.T
    feet = moved(-shape.planes[:, 3:] * shape.planes[:, :3])
    planes = np.column_stack([normals, -np.einsum("ki,ki->k", normals, feet)])
    axis = None if shape.axis is None else np.stack([moved(shape.axis[0]), turn @ shape.axis[1]])
    there = replace(
        shape,
        triangles=moved(shape.triangles),
        planes=planes,
        axis=axis,
        hidden=hidden if shape.hidden else None,
        up=turn @ shape.up,
    )
    return there, moved(centre), scale * diagonal
