"""What may be believed of the fates that trials show: only what follows from what a filter is.

Trials are made with defaults, or one value changed, on a few sound shapes. Whether faces, edges,
normals or selections are left or made hangs on numbers and on the shape, so that a trial shows
little of them.
"""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["believed", "believed_of_made"]

Fates = Mapping[str, str]  # by fact: what it becomes where it did not hold, and where it did

STRUCTURE = ("points", "faces", "edges", "normals")
SELECTIONS = ("vertex_selection", "face_selection")
STAYS = "ny"
# The only facts that are certainly lost, by filter.
LOSE: Mapping[str, tuple[str, ...]] = {
    "meshing_remove_all_faces": ("faces", "face_selection"),
    "meshing_remove_selected_faces": ("face_selection",),
    "meshing_remove_selected_vertices": ("vertex_selection",),
    "meshing_remove_selected_vertices_and_faces": ("face_selection",),
}
# Filters that select nothing of what was not selected begin like this.
SELECT_NOTHING = (
    "apply_color", "apply_matrix", "apply_normal", "apply_scalar", "compute_color",
    "compute_matrix", "compute_normal", "compute_scalar", "create_", "delete_",
    "generate_copy_of_current_mesh", "generate_sampling_montecarlo", "get_geometric_measures",
    "meshing_invert_face_orientation", "meshing_remove_all_faces", "meshing_remove_selected_",
    "meshing_remove_unreferenced_vertices", "set_",
)  # fmt: skip
# Filters whose new layers are clouds begin like this.
MAKE_CLOUDS = (
    "create_sphere_points", "generate_dust_accumulation_point_cloud",
    "generate_sampling_clustered_vertex", "generate_sampling_element",
    "generate_sampling_montecarlo", "generate_sampling_poisson_disk",
    "generate_sampling_regular_recursive", "generate_sampling_stratified_triangle",
    "generate_sampling_texel", "generate_simplified_point_cloud", "get_hausdorff_distance",
)  # fmt: skip
MAKE_POLYLINES = "generate_polyline_"
CREATE = "create_"  # from nothing
CREATE_SELECTED = "create_sphere_cap"
# New layers that are what the current one is, or a part of it.
COPY = "generate_copy_of_current_mesh"
MAKE_PARTS = ("generate_from_selected_", "generate_splitting_by_connected_components")


def believed(name: str, fates: Fates | None) -> Fates | None:
    """Return what is certain of a layer that a filter leaves behind.

    Parameters
    ----------
    name : str
        The filter's Python name.
    fates : mapping or None
        What trials show; what is absent stays; None: nothing.

    Returns
    -------
    mapping or None
        What is lost is unknown, unless losing it is what the filter is for; what is given in faces
        and the like is unknown; nothing is known of selections, unless the filter selects nothing.
    """
    if fates is None:
        return None
    found = {}
    for fact in {*fates, *SELECTIONS}:
        fate = fates.get(fact, STAYS)
        without, held = fate[0], fate[1]
        if held == "n" and fact not in LOSE.get(name, ()):
            held = "?"
        if fact in STRUCTURE and without == "y":
            without = "?"
        if fact in SELECTIONS and without == "n" and not name.startswith(SELECT_NOTHING):
            without = "?"
        found[fact] = without + held
    return found


def believed_of_made(name: str, fates: Fates | None) -> Fates | None:
    """Return what is certain of the new layers of a filter.

    Parameters
    ----------
    name : str
        The filter's Python name.
    fates : mapping or None
        What trials show, seen from the layer that was current; None: nothing.

    Returns
    -------
    mapping or None
        Whether there are points, faces, edges, normals or selections is known only where it follows
        from what the filter makes.
    """
    if fates is None or name == COPY:
        return fates
    found = dict(fates)
    found |= dict.fromkeys(("faces", "edges", "normals", *SELECTIONS), "??")
    if not name.startswith((*MAKE_CLOUDS, CREATE)):
        found["points"] = "??"
    if name.startswith(MAKE_POLYLINES):
        found["faces"] = fates.get("faces", STAYS)
    if name.startswith(MAKE_CLOUDS):
        found |= {"faces": "nn", "edges": "nn"}
    if name.startswith(MAKE_PARTS):  # what there is not at all is in no part, either
        found |= dict.fromkeys(STRUCTURE, "n?")
    if name.startswith(CREATE):
        found["edges"] = "nn"
        if name != CREATE_SELECTED:
            found |= dict.fromkeys(SELECTIONS, "nn")
    return found
