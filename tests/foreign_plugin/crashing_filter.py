"""A filter that ends the process, as native code does when it crashes."""

import os
import signal

from meshlab_symrecon.plugin import Filter, Outcome, ParameterSet, boolean


class Parameters(ParameterSet):
    """Whether to crash at all."""

    crash: bool = boolean(True, "Crash", "End the process.")


def run(layers, parameters, progress):
    progress(0.5, "about to crash")
    if parameters.crash:
        os.kill(os.getpid(), signal.SIGSEGV)
    return Outcome(measures={"points": len(layers.current.points)})


FILTER = Filter(
    menu_name="Crash Here",
    python_name="get_crash",
    aliases=(),
    summary="Crash.",
    description="Ends the process.",
    parameters=Parameters,
    run=run,
    meshlab_class="Measure",
    category="Measurement/Geometric",
)
