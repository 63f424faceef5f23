"""What filters measured, as plain data for JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from meshlab_symrecon.host.reconstruction import Reconstruction

__all__ = ["OF_A_PLANE", "detection", "findings", "is_detection", "plain"]

OF_A_PLANE = ("support", "residual", "confidence")


def plain(value: Any) -> Any:
    """Return lists, dicts, texts and numbers for JSON; what is no finite number becomes None."""
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, (str, bytes)):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return _plain_object(value)


def _plain_object(value: Any) -> Any:
    """Return the corners of a box of pymeshlab, the fields of a record, or the words of others."""
    if hasattr(value, "diagonal"):
        return {"min": plain(value.min()), "max": plain(value.max())}
    if is_dataclass(value):
        return {known.name: plain(getattr(value, known.name)) for known in fields(value)}
    return str(value)


def is_detection(measures: Mapping[str, Any]) -> bool:
    """Say whether a filter measured reflection planes."""
    return {"planes", "converged", *OF_A_PLANE} <= set(measures)


def detection(measures: Mapping[str, Any]) -> dict[str, Any]:
    """Return the planes that were found, one record each, best first."""
    columns = zip(*(np.atleast_1d(measures[name]) for name in OF_A_PLANE), strict=True)
    planes = np.reshape(measures["planes"], (-1, 4))
    return {
        "planes": [
            {"plane": plain(plane), **dict(zip(OF_A_PLANE, plain(row), strict=True))}
            for plane, row in zip(planes, columns, strict=True)
        ],
        "converged": bool(measures["converged"]),
    }


def findings(result: Reconstruction) -> dict[str, Any]:
    """Return what the whole method found and measured: planes, points, completion, surface."""
    completed = plain(result.completed)
    return {
        **detection(result.found),
        "measured": completed.pop("measured"),
        "mirrored": completed.pop("mirrored"),
        "completion": completed,
        "surface": plain(result.surface),
    }
