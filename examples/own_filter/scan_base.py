"""Cut a scan off the table it stands on: a filter of one's own, as a package of its own."""

import numpy as np

from meshlab_symrecon.plugin import Filter, Layer, Outcome, ParameterSet, choice, number


class Parameters(ParameterSet):
    """Where to cut."""

    up: str = choice("y", ("x", "y", "z"), "Up", "The axis that points up.")
    share: float = number(0.1, "Share", "Share of the height to cut off.", low=0.0, high=1.0)


def run(layers, parameters, progress):
    """Return the points above the cut, and how many there are."""
    scan = layers.current
    heights = scan.points[:, "xyz".index(parameters.up)]
    kept = heights >= heights.min() + parameters.share * np.ptp(heights)
    present = {name: getattr(scan, name) for name in ("points", "normals", "colours", "quality")}
    values = {name: rows[kept] for name, rows in present.items() if rows is not None}
    cloud = Layer(faces=np.zeros((0, 3), dtype=np.int64), label="without base", **values)
    return Outcome((cloud,), measures={"kept": int(kept.sum()), "cut": int((~kept).sum())})


FILTER = Filter(
    menu_name="Cut Off the Base",
    python_name="generate_scan_without_base",
    aliases=("cut_base",),
    summary="Cut a scan off the table it stands on.",
    description="Adds the points above the cut as a cloud.\n\nReturns how many are `kept`, `cut`.",
    parameters=Parameters,
    run=run,
    meshlab_class="Sampling",
    category="Creation/Sampling",
    creates=("without base",),
)
