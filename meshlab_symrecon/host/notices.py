"""Warnings that point at the user's own line."""

from __future__ import annotations

import sys
import warnings

from meshlab_symrecon.errors import SymReconWarning

__all__ = ["warn_user"]

OUR_PACKAGE = "meshlab_symrecon"


def warn_user(sentence: str) -> None:
    """Warn at the innermost line of code that is not ours."""
    frame = sys._getframe(1)
    depth = 2  # 1 is this function, 2 the one that called it
    while frame.f_back is not None and _is_ours(frame.f_globals.get("__name__", "")):
        frame = frame.f_back
        depth += 1
    warnings.warn(sentence, SymReconWarning, stacklevel=depth)


def _is_ours(module: str) -> bool:
    return module == OUR_PACKAGE or module.startswith(f"{OUR_PACKAGE}.")
