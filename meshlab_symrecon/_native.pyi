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
def fine_power_determinant(
    points: NDArray[np.float64], weights: NDArray[np.float64], fused: bool
) -> float: ...
def perturbed_power_test(points: NDArray[np.float64], weights: NDArray[np.float64]) -> int: ...
def mixed_edge_polygons(
    cells: NDArray[np.int32], neighbours: NDArray[np.int32], inside: NDArray[np.uint8]
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]: ...
def contract_edges(
    points: NDArray[np.float64],
    faces: NDArray[np.int32],
    anchor: NDArray[np.int32],
    anchor_points: NDArray[np.float64],
    shortest: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.int32]]: ...
def find_poles(
    points: NDArray[np.float64], cells: NDArray[np.int32], samples: int
) -> tuple[
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.int32],
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.float64],
]: ...
def lexicographic_order(points: NDArray[np.float64]) -> NDArray[np.int32]: ...
def label_pieces(cells: NDArray[np.int32], labels: NDArray[np.uint8]) -> NDArray[np.int32]: ...
def surface_topology(
    faces: NDArray[np.int32], vertex_count: int
) -> tuple[int, int, int, int, int, int, int, NDArray[np.int32]]: ...
