"""Types of the compiled kernel; see the headers in ``native/`` for what each function computes."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

def regular_triangulation(
    points: NDArray[np.float64],
    weights: NDArray[np.float64],
    progress: Callable[[float], object] | None = None,
) -> tuple[int, NDArray[np.int32], NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]: ...
def orthocentres(
    points: NDArray[np.float64], weights: NDArray[np.float64], cells: NDArray[np.int32]
) -> NDArray[np.float64]: ...
def orientation(points: NDArray[np.float64], stage: int = 0) -> int: ...
def power_test(
    points: NDArray[np.float64], weights: NDArray[np.float64], stage: int = 0
) -> int: ...
def perturbed_power_test(points: NDArray[np.float64], weights: NDArray[np.float64]) -> int: ...
def mixed_edge_polygons(
    cells: NDArray[np.int32],
    neighbours: NDArray[np.int32],
    inside: NDArray[np.uint8],
    progress: Callable[[float], object] | None = None,
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]: ...
def power_vertices(
    centres: NDArray[np.float64],
    radii: NDArray[np.float64],
    samples: NDArray[np.int32],
    sites: NDArray[np.float64],
    sample_count: int,
    cells: NDArray[np.int32],
    chosen: NDArray[np.int32],
    reach: float,
    progress: Callable[[float], object] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int32], int]: ...
def join_at_samples(
    positions: NDArray[np.float64],
    nearest: NDArray[np.int32],
    offsets: NDArray[np.int32],
    corners: NDArray[np.int32],
    samples: NDArray[np.float64],
    progress: Callable[[float], object] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]: ...
def contract_edges(
    points: NDArray[np.float64],
    faces: NDArray[np.int32],
    nearest: NDArray[np.int32],
    samples: NDArray[np.float64],
    spacing: NDArray[np.float64],
    weld: float,
    flat: float,
    progress: Callable[[float], object] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]: ...
def pole_cells(
    sites: NDArray[np.float64],
    centres: NDArray[np.float64],
    cells: NDArray[np.int32],
    samples: int,
) -> tuple[NDArray[np.int32], NDArray[np.int32]]: ...
def sample_spacings(
    sites: NDArray[np.float64], cells: NDArray[np.int32], samples: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def label_pieces(cells: NDArray[np.int32], labels: NDArray[np.uint8]) -> NDArray[np.int32]: ...
def surface_topology(
    faces: NDArray[np.int32], vertex_count: int
) -> tuple[int, int, int, int, int, int, int, NDArray[np.int32]]: ...
