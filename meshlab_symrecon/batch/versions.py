"""Which versions make a result."""

from __future__ import annotations

from functools import cache
from importlib import metadata

from meshlab_symrecon import __version__

__all__ = ["versions"]


@cache
def versions() -> dict[str, str]:
    """Return the versions of what computes."""
    names = ("pymeshlab", "numpy", "scipy")
    return {"meshlab_symrecon": __version__} | {name: metadata.version(name) for name in names}
