"""Checksums of files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from meshlab_symrecon.host import checksums

__all__ = ["sha256_of", "sha256_of_data"]


def sha256_of(path: Path) -> str | None:
    """Return the checksum of a file, as ``sha256sum`` tells it; None when it cannot be read."""
    try:
        if not path.is_file():  # reading from a pipe would wait for ever
            return None
        return checksums.sha256_of(path)
    except (OSError, ValueError):
        return None


def sha256_of_data(data: Mapping[str, Any]) -> str:
    """Return the checksum of plain data, whatever its order."""
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()
