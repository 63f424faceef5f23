"""A filter that does to its process what the number of points says.

Where AWKWARD_GATE is in the environment, large scans wait for a file of that name.
"""

import os
import signal
import time
from pathlib import Path

import numpy as np

from meshlab_symrecon.plugin import Filter, Outcome, ParameterSet

CRASHES, SWELLS, GRASPS, DIVIDES, SLEEPS, LINGERS = 77, 78, 79, 80, 81, 200


class Parameters(ParameterSet):
    """None."""


def run(layers, parameters, progress):
    count = len(layers.current.points)
    progress(0.5, "being awkward")
    if count == CRASHES:
        os.kill(os.getpid(), signal.SIGSEGV)
    if count == SWELLS:
        held = []
        while True:
            held.append(np.ones(1 << 20))
            time.sleep(0.002)
    if count == GRASPS:
        np.zeros(1 << 33)
    if count == DIVIDES:
        1 / (count - DIVIDES)
    if count == SLEEPS:
        time.sleep(600)
    gate = os.environ.get("AWKWARD_GATE")
    while gate and count >= LINGERS and not Path(gate).exists():
        time.sleep(0.01)
    return Outcome(measures={"points": count})


FILTER = Filter(
    menu_name="Be Awkward",
    python_name="get_awkward",
    aliases=(),
    summary="Be awkward.",
    description="Does what the number of points says.",
    parameters=Parameters,
    run=run,
    meshlab_class="Measure",
    category="Measurement/Geometric",
)
