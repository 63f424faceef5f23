"""What commands report: measures as plain data for JSON, and in words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.measures import detection, is_detection, plain

__all__ = ["detection", "is_detection", "measures_in_words", "plain", "write_json"]

SHOWN = 4  # numbers of an array that are shown in words


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
