"""What commands report: measures as plain data for JSON, and in words."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon.host.atomic import replacing

__all__ = ["detection", "is_detection", "measures_in_words", "plain", "write_json"]

SHOWN = 4  # numbers of an array that are shown in words
OF_A_PLANE = ("support", "residual", "confidence")


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write plain data, whole or not at all.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    text = json.dumps(plain(data), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    with replacing(path) as staged:
        staged.write_bytes(text.encode("utf-8", "backslashreplace"))


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


def measures_in_words(measures: Mapping[str, Any]) -> list[str]:
    """Return one line for each measure; long arrays by their shape."""
    return [f"{name}: {_in_words(value)}" for name, value in measures.items()]


def _in_words(value: Any) -> str:
    if isinstance(value, np.ndarray) and value.size > SHOWN:
        return "array of " + " x ".join(str(length) for length in value.shape)
    if isinstance(value, bool):
        return "yes" if value else "no"
    shown = plain(value)
    return f"{shown:g}" if isinstance(shown, float) else str(shown)
