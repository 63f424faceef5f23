"""How far a scan is from its own mirror image, measured in a document of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from meshlab_symrecon.errors import GeometryError
from meshlab_symrecon.host.reconstruction import PLANES, SCAN, Reconstruction, noted

if TYPE_CHECKING:
    from meshlab_symrecon.arrays import Floats
    from meshlab_symrecon.host.history import Step

__all__ = ["DEVIATION", "Deviation", "measured_deviation"]

DEVIATION = "compute_scalar_by_mirror_symmetry_per_vertex"
DISTANCES, COUNTERPART = "mirror_deviation", "has_counterpart"  # attributes that it writes


@dataclass(frozen=True, slots=True, eq=False)
class Deviation:
    """What the filter measured, and its step.

    Attributes
    ----------
    distances : (n,) float or None
        Of every point of the scan from its mirror image across the best plane, negative inside;
        NaN where there is nothing to compare with. None: nothing was measured.
    measures : mapping
        What the filter returned.
    steps : tuple of Step
        The step as it ran.
    warnings : tuple of str
    """

    distances: Floats | None = None
    measures: Mapping[str, Any] = field(default_factory=dict)
    steps: tuple[Step, ...] = ()
    warnings: tuple[str, ...] = ()


def measured_deviation(result: Reconstruction) -> Deviation:
    """Measure the scan of a reconstruction across its best plane; its document stays as it is."""
    import numpy as np

    from meshlab_symrecon.host.files import new_document
    from meshlab_symrecon.host.history import read_history
    from meshlab_symrecon.host.meshset import add_layer, current_identifier, read_layer
    from meshlab_symrecon.host.registration import apply_filter

    if PLANES not in result.layers:
        return Deviation()
    apart = new_document()
    add_layer(apart, read_layer(result.mesh_set, result.layers[PLANES]), current=False)
    add_layer(apart, read_layer(result.mesh_set, result.layers[SCAN]), current=True)
    try:
        with noted() as sentences:
            measures = apply_filter(apart, DEVIATION)
    except GeometryError as error:
        return Deviation(warnings=(f"the deviation was not measured: {error}",))
    scan = read_layer(apart, current_identifier(apart))
    known = scan.attributes[COUNTERPART] != 0.0
    distances = np.where(known, scan.attributes[DISTANCES], np.nan)
    return Deviation(distances, measures, read_history(apart), tuple(sentences))
