"""The colours of a map of deviation: blue inside, pale where both sides agree, red outside."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshlab_symrecon.arrays import as_scalars
from meshlab_symrecon.errors import GeometryError, ParameterError

__all__ = ["STOPS", "UNKNOWN", "UNSIGNED_STOPS", "colour_limit", "deviation_colours"]

# Shares of the limit and their sRGB colours; between them colours are mixed.
STOPS = (
    (-1.0, (22, 58, 128)),
    (-0.6, (52, 112, 180)),
    (-0.25, (146, 186, 216)),
    (0.0, (243, 242, 240)),
    (0.25, (236, 172, 136)),
    (0.6, (204, 82, 62)),
    (1.0, (136, 16, 32)),
)
UNSIGNED_STOPS = tuple(stop for stop in STOPS if stop[0] >= 0.0)  # of distances without sign
UNKNOWN = (132, 130, 127)  # nothing to compare with
COMMON = 0.98  # share of the distances that the colours must tell apart
ROUND = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)  # numbers that are easily read off a bar


def deviation_colours(
    distances: ArrayLike, has_counterpart: ArrayLike, limit: float
) -> NDArray[np.uint8]:
    """Return the colour of every distance.

    Parameters
    ----------
    distances : (n,) float
        Signed distances.
    has_counterpart : (n,) bool
        False: grey, nothing to compare with.
    limit : float
        The distance of the deepest colours, as from `colour_limit`; larger ones get the same.

    Returns
    -------
    (n, 3) uint8
        sRGB.

    Raises
    ------
    GeometryError
        Distances that are not finite, or not as many booleans.
    ParameterError
        A limit that is not positive.
    """
    values, known = _checked(distances, has_counterpart)
    if not (np.isfinite(limit) and limit > 0.0):
        message = f"the limit of the colours must be positive; got {limit!r}; use colour_limit()"
        raise ParameterError(message)
    places = [place for place, _ in STOPS]
    channels = np.array([colour for _, colour in STOPS], dtype=float).T
    mixed = np.column_stack([np.interp(values / limit, places, channel) for channel in channels])
    mixed[~known] = UNKNOWN
    colours: NDArray[np.uint8] = np.round(mixed).astype(np.uint8)
    return colours


def colour_limit(distances: ArrayLike, has_counterpart: ArrayLike) -> float:
    """Choose a limit for the colours: a round number that 98 % of the distances stay below.

    Parameters
    ----------
    distances : (n,) float
        Signed distances.
    has_counterpart : (n,) bool
        Those that count.

    Returns
    -------
    float
        Positive; 1 when there is no distance but 0.

    Raises
    ------
    GeometryError
        Distances that are not finite, or not as many booleans.
    """
    values, known = _checked(distances, has_counterpart)
    sizes = np.abs(values[known])
    common = float(np.quantile(sizes, COMMON)) if len(sizes) else 0.0
    if common <= 0.0:
        return 1.0
    power = int(np.floor(np.log10(common)))
    rounded = (float(f"{number}e{power}") for number in ROUND)
    return next((number for number in rounded if number >= common), float(f"1e{power + 1}"))


def _checked(
    distances: ArrayLike, has_counterpart: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    known = np.asarray(has_counterpart)
    values = as_scalars(distances, np.size(distances), "distances")
    if known.shape != values.shape or known.dtype != np.bool_:
        message = (
            f"has_counterpart must be {len(values)} booleans, one a distance; got {known.dtype} "
            f"of shape {known.shape}; take it from the same step"
        )
        raise GeometryError(message)
    return values, known
