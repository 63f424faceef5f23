"""Defaults that MeshLab forgets: some filters take what was given to them last as their default.

In MeshLab's window that is a help; in a process that runs many scripts it lets one script change
the next. So what is left out is set to what it is in a fresh process. Found by running every
filter with other values than its defaults, and asking for the defaults again.
"""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["first_defaults"]

_ALIGNMENT: Mapping[str, object] = {
    "samplenum": 2000,
    "mindistabs": 10.0,
    "trgdistabs": 0.005,
    "maxiternum": 75,
    "samplemode": True,
    "reducefactorperc": 0.8,
    "passhifilter": 0.75,
    "matchmode": True,
}
_FIRST: Mapping[str, Mapping[str, object]] = {
    "compute_matrix_by_icp_between_meshes": _ALIGNMENT,
    "compute_matrix_by_mesh_global_alignment": {
        **_ALIGNMENT,
        "ogsize": 50000,
        "arcthreshold": 0.3,
    },
    "meshing_decimation_quadric_edge_collapse": {
        "qualitythr": 0.3,
        "preserveboundary": False,
        "preservenormal": False,
        "preservetopology": False,
        "optimalplacement": True,
        "planarquadric": False,
        "planarweight": 0.001,
        "qualityweight": False,
    },
    "meshing_decimation_quadric_edge_collapse_with_texture": {
        "qualitythr": 0.3,
        "extratcoordw": 1.0,
        "preserveboundary": False,
        "optimalplacement": True,
        "preservenormal": False,
        "planarquadric": False,
    },
    "meshing_isotropic_explicit_remeshing": {
        "iterations": 10,
        "adaptive": False,
        "selectedonly": False,
        "featuredeg": 30.0,
        "checksurfdist": True,
        "splitflag": True,
        "collapseflag": True,
        "swapflag": True,
        "smoothflag": True,
        "reprojectflag": True,
    },
}


def first_defaults(python_name: str) -> Mapping[str, object]:
    """Return the defaults, in a fresh process, that a filter would not keep; none for most."""
    return _FIRST.get(python_name, {})
