"""The loops over planes and points as sums of numpy: what the compiled ones must find."""

import numpy as np
from scipy.spatial import cKDTree

from meshlab_symrecon.geometry.neighbours import tangent_bases
from meshlab_symrecon.symmetry import refinement, verification

TINY = float(np.finfo(np.float64).tiny)


def examined(planes, cloud, count, nearest, tolerance):
    """Support, agreement, contradiction and residual, four arrays (k,)."""
    landed = landings(planes, cloud, cloud.samples[:count], nearest, tolerance)
    weights, distances = landed["weights"], landed["distances"]
    blamed = ~(landed["excused"] | landed["broken_off"])
    far = (
        (distances > max(verification.FAR, verification.FAR_SPACINGS * cloud.spacing))
        & (distances < verification.BEYOND)
        & ~landed["rim_near"]
        & ~landed["missing"]
    )
    total = np.maximum(weights.sum(axis=1), TINY)
    worth = weights * landed["worth"]
    matched = worth.sum(axis=1)
    return (
        matched / total,
        (worth * blamed).sum(axis=1) / np.maximum((weights * blamed).sum(axis=1), TINY),
        (weights * far) @ cloud.distinctness[:count] / total,
        np.sqrt((worth * landed["off_squares"]).sum(axis=1) / np.maximum(matched, TINY)),
    )


def landings(planes, cloud, queries, nearest, tolerance):
    """Where the mirror images fall: arrays (k, q) by the names of `verification.Landings`."""
    points, directions = cloud.points[queries], cloud.normals[queries]
    normals = planes[:, :3]
    heights = normals @ points.T + planes[:, 3:]
    mirrored = points - 2.0 * heights[..., np.newaxis] * normals[:, np.newaxis]
    partners = nearest(mirrored)
    gaps = mirrored - cloud.points[partners]
    distances = np.sqrt(np.einsum("kqi,kqi->kq", gaps, gaps))
    partner_normals = cloud.normals[partners]
    cosines = np.einsum("kqi,qi->kq", partner_normals, directions)
    along = np.einsum("kqi,ki->kq", partner_normals, normals)
    cosines = cosines - 2.0 * along * (normals @ directions.T)
    signed = cloud.oriented[queries] & cloud.oriented[partners]
    cosines = np.where(signed, cosines, np.abs(cosines))
    off_squares = np.einsum("kqi,kqi->kq", gaps, partner_normals) ** 2
    sideways = np.maximum(distances**2 - off_squares, 0.0)
    none, full = verification.DIRECTION_RAMP
    tolerance = max(tolerance, verification.TOLERANCE_SPACINGS * cloud.spacing)
    worth = np.exp(-0.5 * off_squares / tolerance**2)
    worth *= np.clip((cosines - none) / (full - none), 0.0, 1.0)
    reach = np.clip(
        verification.SIDEWAYS * cloud.spacing,
        verification.LEAST_SIDEWAYS,
        verification.MOST_SIDEWAYS,
    )
    worth[sideways > reach**2] = 0.0
    missing = mirrored @ cloud.broken_off[:3] + cloud.broken_off[3] < 0.0
    rim_near = cloud.border_distance[partners] <= verification.RIM_REACH * distances
    unmatched = worth < verification.NO_MATCH
    hole = rim_near & (distances > verification.LEAST_GAP * cloud.spacing)
    return {
        "partners": partners,
        "weights": np.minimum(1.0, np.abs(heights) / verification.NEAR_PLANE),
        "distances": distances,
        "cosines": cosines,
        "worth": worth,
        "excused": unmatched & hole & ~missing,
        "broken_off": unmatched & missing,
        "off_squares": off_squares,
        "rim_near": rim_near,
        "missing": missing,
    }


def refined(planes, queries, cloud, nearest, schedule):
    """Refine planes; queries and cloud are pairs of points and normals."""
    normals, offsets = planes[:, :3].copy(), -planes[:, 3].copy()
    for step in range(schedule.steps):
        system, gradient, partners = normal_equations(
            (normals, offsets), queries, cloud, nearest, schedule.tolerances(step)
        )
        ridge = refinement.RIDGE * np.trace(system, axis1=1, axis2=2) + np.finfo(float).tiny
        system += ridge[:, np.newaxis, np.newaxis] * np.eye(3)
        moves = -np.linalg.solve(system, gradient[..., np.newaxis])[..., 0]
        moves[partners < refinement.FEWEST] = 0.0
        turns = np.linalg.norm(moves[:, :2], axis=1, keepdims=True)
        moves *= np.minimum(
            1.0, refinement.LARGEST_TURN / np.maximum(turns, refinement.LARGEST_TURN)
        )
        first, second = tangent_bases(normals)
        normals = normals + moves[:, :1] * first + moves[:, 1:2] * second
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        offsets = offsets + moves[:, 2]
        if step >= 0.6 * schedule.steps and np.abs(moves).max(initial=0.0) < refinement.SETTLED:
            break
    return np.column_stack([normals, -offsets])


def normal_equations(planes, queries, cloud, nearest, tolerances):
    """Gauss-Newton systems (k, 3, 3), gradients (k, 3) and numbers of partners (k,)."""
    normals, offsets = planes
    points, directions = queries
    first, second = tangent_bases(normals)
    heights = normals @ points.T - offsets[:, np.newaxis]  # (k, q)
    mirrored = points - 2.0 * heights[..., np.newaxis] * normals[:, np.newaxis]
    partners = nearest(mirrored)
    gaps = mirrored - cloud[0][partners]
    partner_normals = cloud[1][partners]
    squares = np.einsum("kqi,kqi->kq", gaps, gaps)
    along = np.einsum("kqi,ki->kq", partner_normals, normals)
    agreement = np.einsum("kqi,qi->kq", partner_normals, directions)
    agreement = np.abs(agreement - 2.0 * along * (normals @ directions.T))
    relative = squares / tolerances[..., np.newaxis] ** 2
    none, full = refinement.DIRECTION_RAMP
    weights = np.exp(-0.5 * relative)
    weights *= np.clip((agreement - none) / (full - none), 0.0, 1.0)
    weights[relative > refinement.REACH**2] = 0.0
    residuals = np.einsum("kqi,kqi->kq", gaps, partner_normals)

    def slopes(targets, towards):
        """Derive ``targets . mirrored`` by the turns and the offset, (k, q, 3)."""
        columns = [
            -2.0 * (heights * np.einsum("kqi,ki->kq", targets, axis) + (axis @ points.T) * towards)
            for axis in (first, second)
        ]
        return np.stack([*columns, 2.0 * towards], axis=-1)

    jacobian = slopes(partner_normals, along)
    weighted = weights[..., np.newaxis] * jacobian
    system = np.einsum("kqi,kqj->kij", weighted, jacobian)
    gradient = np.einsum("kqi,kq->ki", weighted, residuals)
    # Point to point: by turns  -2 (t u + (p . u) n), by the offset  2 n; u, v, n are orthonormal.
    rows = np.stack([-2.0 * (axis @ points.T) for axis in (first, second)], axis=-1)
    rows = np.concatenate([rows, np.full((*heights.shape, 1), 2.0)], axis=-1)  # along n
    along_gap = np.einsum("kqi,ki->kq", gaps, normals)
    share = refinement.POINT_SHARE * weights
    system += np.einsum("kqi,kqj,kq->kij", rows, rows, share)
    spread = 4.0 * np.einsum("kq,kq->k", heights**2, share)
    system[:, 0, 0] += spread
    system[:, 1, 1] += spread
    gradient += np.einsum("kqi,kq->ki", rows, share * along_gap)
    for column, axis in enumerate((first, second)):
        sideways = np.einsum("kqi,ki->kq", gaps, axis)
        gradient[:, column] -= 2.0 * np.einsum("kq,kq->k", heights * sideways, share)
    return system, gradient, (weights > 0.0).sum(axis=1)


def voting_pairs(points, normals, oriented, shortest, least_cosine):
    """Pairs (k, 2) that the votes come from."""
    squares = (points**2).sum(axis=1)
    lengths = squares[:, np.newaxis] + squares - 2.0 * points @ points.T
    np.fill_diagonal(lengths, 0.0)
    heights = points @ normals.T  # p_i . N_j
    own = np.diagonal(heights)
    # (I - 2 n n^T) N_i . N_j  with  n = (p_i - p_j) / |p_i - p_j|
    products = (own[:, np.newaxis] - heights.T) * (heights - own)
    agreement = normals @ normals.T - 2.0 * products / np.maximum(lengths, shortest**2)
    signed = oriented[:, np.newaxis] & oriented
    agreement = np.where(signed, agreement, np.abs(agreement))
    accepted = (agreement > least_cosine) & (lengths > shortest**2)
    return np.argwhere(np.triu(accepted, 1))


def partners_of(cloud, exact):
    """Look partners of places (..., 3) up in the table, or search the closest ones."""
    if exact:
        tree = cKDTree(cloud.points)
        return lambda places: tree.query(places)[1]
    return lambda places: cloud.field.lookup(places.reshape(-1, 3)).reshape(places.shape[:-1])
