"""Which layer is current after a step that makes one: what the author of an old script had seen.

In MeshLab up to 2016.12, Screened Poisson and Poisson-disk Sampling left the layer current that
they worked on; today the new one becomes current. A script does not tell its version, but one that
deletes the current layer right after making another can only mean the old one.
"""

from __future__ import annotations

from collections.abc import Sequence

from meshlab_symrecon.host.mlx import Step
from meshlab_symrecon.host.old_names import NOTHING

__all__ = ["KEPT", "MADE", "current_is_kept", "current_was_kept"]

DELETE = "delete_current_mesh"
MAKERS = ("generate_surface_reconstruction_", "generate_sampling_", "generate_marching_cubes_",
          "generate_resampled_", "generate_simplified_point_cloud", "generate_alpha_",
          "generate_convex_hull")  # fmt: skip
POISSON = "generate_surface_reconstruction_screened_poisson"

KEPT = (
    "the layer that it worked on stays current, as in the MeshLab of such scripts, since the next "
    "step deletes the current one"
)
MADE = "the layer that it makes becomes current; up to MeshLab 2016.12 the old one stayed current"


def current_is_kept(names: Sequence[str], number: int) -> bool:
    """Say whether the layer that a step works on must stay current.

    Parameters
    ----------
    names : sequence of str
        Python names of today of all steps; empty for those that cannot run.
    number : int
        Position of the step.
    """
    acting = (name for name in names[number + 1 :] if name not in ("", NOTHING))
    return names[number].startswith(MAKERS) and next(acting, "") == DELETE


def current_was_kept(name: str, step: Step) -> bool:
    """Say whether the MeshLab that wrote a step left the layer current that it worked on."""
    return name == POISSON and step.from_xml_plugin
