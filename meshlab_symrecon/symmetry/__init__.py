"""Reflection planes of incomplete clouds, and completion by mirroring."""

from meshlab_symrecon.symmetry.completion import mirror_complete
from meshlab_symrecon.symmetry.detection import detect_reflection_planes, refine_reflection_planes

__all__ = ["detect_reflection_planes", "mirror_complete", "refine_reflection_planes"]
