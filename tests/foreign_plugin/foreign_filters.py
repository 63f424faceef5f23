"""A package of somebody else that declares filters in our entry-point group."""

from meshlab_symrecon.plugin import Filter, Outcome, ParameterSet, integer


class Parameters(ParameterSet):
    """How many points to keep."""

    every: int = integer(2, "Every", "Keep one point out of this many.", low=1)


def run(layers, parameters, progress):
    return Outcome(measures={"kept": len(layers.current.points[:: parameters.every])})


FILTER = Filter(
    menu_name="Count Every Other Point",
    python_name="get_every_other_point",
    aliases=("count_others",),
    summary="Count points.",
    description="Counts one point out of so many.",
    parameters=Parameters,
    run=run,
    meshlab_class="Measure",
    category="Measurement/Geometric",
)

NOT_A_FILTER = "a text"
