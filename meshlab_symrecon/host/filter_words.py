"""What a filter of MeshLab's does, in one sentence, told from its Python name.

pymeshlab's names follow a law: a verb, what it changes, how, and for what (``per_vertex``).
"""

from __future__ import annotations

__all__ = ["sentence_of"]

BEGINNINGS = {  # the longest one that fits is taken
    "apply_": "Applies",
    "apply_color_": "Changes colours:",
    "apply_coord_": "Moves vertices:",
    "apply_matrix_": "Changes the layer's transform matrix:",
    "apply_normal_": "Changes normals:",
    "apply_scalar_": "Changes the quality (one number each):",
    "apply_selection_": "Changes the selection:",
    "apply_texcoord_": "Changes texture coordinates:",
    "apply_texmap_": "Changes the texture:",
    "compute_": "Computes",
    "compute_color_": "Sets colours:",
    "compute_coord_": "Moves vertices:",
    "compute_matrix_": "Moves, turns or scales by the layer's transform matrix:",
    "compute_new_custom_": "Adds a custom",
    "compute_normal_": "Computes normals:",
    "compute_scalar_": "Computes the quality (one number each):",
    "compute_selection_": "Selects:",
    "compute_selection_by_": "Selects by",
    "compute_texcoord_": "Computes texture coordinates:",
    "compute_texmap_": "Computes a texture:",
    "create_": "Makes a new layer:",
    "delete_": "Deletes",
    "export_": "Exports:",
    "generate_": "Makes a new layer:",
    "generate_sampling_": "Makes a new layer of samples:",
    "generate_surface_reconstruction_": "Makes a new layer with a surface through the points:",
    "get_": "Measures, and changes nothing:",
    "load_": "Loads",
    "meshing_": "Changes the mesh:",
    "meshing_close_": "Closes",
    "meshing_cut_": "Cuts",
    "meshing_decimation_": "Makes the mesh coarser:",
    "meshing_edge_flip_by_": "Flips edges between faces by",
    "meshing_invert_": "Inverts",
    "meshing_merge_": "Merges",
    "meshing_re_orient_": "Orients anew",
    "meshing_refine_": "Divides edges",
    "meshing_remove_": "Removes",
    "meshing_repair_": "Repairs",
    "meshing_snap_": "Snaps",
    "meshing_surface_subdivision_": "Divides faces into smaller ones:",
    "save_": "Saves",
    "set_": "Sets",
    "transfer_": "Carries over from one layer to another:",
}
ENDINGS = {
    "_per_vertex": "for each vertex",
    "_per_face": "for each face",
    "_per_edge": "for each edge",
    "_per_wedge": "for each corner of a face",
    "_per_mesh": "for the layer as a whole",
    "_per_raster": "for each picture",
}
WORDS = {"conntected": "connected", "icp": "ICP", "hc": "HC", "mls": "MLS", "apss": "APSS",
         "rimls": "RIMLS", "vcg": "VCG", "ls3": "LS3", "gpu": "GPU", "poisson": "Poisson",
         "laplacian": "Laplacian", "taubin": "Taubin", "hausdorff": "Hausdorff",
         "voronoi": "Voronoi", "montecarlo": "Monte Carlo"}  # fmt: skip


def sentence_of(python_name: str) -> str:
    """Return a sentence for one of MeshLab's filters."""
    beginning = max(
        (known for known in BEGINNINGS if python_name.startswith(known)), key=len, default=""
    )
    rest = python_name.removeprefix(beginning)
    ending = next((known for known in ENDINGS if rest.endswith(known)), "")
    plain = rest.removesuffix(ending).split("_")
    words = [BEGINNINGS.get(beginning, ""), *(WORDS.get(word, word) for word in plain)]
    tail = f", {ENDINGS[ending]}" if ending else ""
    sentence = " ".join(filter(None, words)) + tail
    return sentence[0].upper() + sentence[1:] + "."
