"""Reflection planes of incomplete clouds, completion by mirroring, and deviation from symmetry."""

from meshlab_symrecon.symmetry.completion import mirror_complete
from meshlab_symrecon.symmetry.detection import detect_reflection_planes, refine_reflection_planes
from meshlab_symrecon.symmetry.deviation import mirror_deviation

__all__ = [
    "detect_reflection_planes",
    "mirror_complete",
    "mirror_deviation",
    "refine_reflection_planes",
]
