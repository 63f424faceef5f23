"""MeshLab filters in Python: complete a statue scan from its mirror symmetry, close it."""

from __future__ import annotations

__version__ = "0.1.0"
