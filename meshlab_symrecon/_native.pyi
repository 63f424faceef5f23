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
