"""The environment by which numerical libraries learn how many threads they may use."""

from __future__ import annotations

__all__ = ["VARIABLES"]

VARIABLES = (
    "OMP_NUM_THREADS",  # MeshLab, scikit-learn
    "OPENBLAS_NUM_THREADS",  # numpy, scipy
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMEXPR_NUM_THREADS",
)
