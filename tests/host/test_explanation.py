"""Scripts in words."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.host.explanation import explained
from meshlab_symrecon.host.filter_script import FilterScript
from meshlab_symrecon.host.filter_words import BEGINNINGS, sentence_of
from meshlab_symrecon.host.mlx import Step
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.native_filters import native_filters
from meshlab_symrecon.host.resolution import matched

OLD = """<FilterScript>
<!-- of the marble head -->
<filter name="Merge Close Vertices">
<Param type="RichAbsPerc" name="Threshold" value="0.05" min="0" max="10"/>
</filter>
<filter name="No Such Filter"/>
<filter name="Distance from Reference Mesh">
<Param type="RichMesh" name="MeasureMesh" value="0"/>
<Param type="RichMesh" name="RefMesh" value="11"/>
<Param type="RichBool" name="SignedDist" value="perhaps"/>
</filter>
<filter name="Change the current layer"><Param type="RichMesh" name="mesh" value="1"/></filter>
<filter name="Compact faces"/>
<xmlfilter name="Screened Poisson"><xmlparam name="depth" value="8"/></xmlfilter>
<filter name="Grow Points"><Param type="RichBool" name="keep" value="true"/></filter>
<!-- done -->
</FilterScript>
"""
WORDS = """1. Merge Close Vertices (line 3)
   In Python: meshing_merge_close_vertices
   Merges close vertices.
   Works on the current layer.
   With:
   - Threshold = 0.05 (0.5 % of 10, the size it was made for)
   Its comment: of the marble head

2. No Such Filter (line 6)
   Does not run.
   MISTAKE: no filter is called 'No Such Filter'; 'symrecon filters --all' lists
   them.

3. Distance from Reference Mesh (line 7)
   In Python: compute_scalar_by_distance_from_another_mesh_per_vertex
   Computes the quality (one number each): by distance from another mesh, for
   each vertex.
   Works on layer 0 (the first) as MeasureMesh and layer 11 (number 12) as
   RefMesh.
   Not given, so chosen when it runs: MaxDist.
   MISTAKE (line 10): parameter 'signeddist' must be true or false; got
   'perhaps'.

4. Change the current layer (line 12)
   Makes layer 1 (the second) the current layer: the next steps work on it.
   Note: the current layer changes, by position.

5. Compact faces (line 13)
   Does nothing today.
   Note: MeshLab does this by itself today.

6. Surface Reconstruction: Screened Poisson (line 14)
   In Python: generate_surface_reconstruction_screened_poisson
   Makes a new layer with a surface through the points: screened Poisson.
   Works on the current layer.
   With:
   - depth = 8
   Not given, so left at MeshLab's defaults: visibleLayer = no, fullDepth = 5,
   cgDepth = 0, scale = 1.1, samplesPerNode = 1.5, pointWeight = 4, iters = 8,
   confidence = no, preClean = no.
   Not given, so chosen when it runs: threads.
   Note: 'Screened Poisson' is 'Surface Reconstruction: Screened Poisson' today.
   Note: the layer that it makes becomes current; up to MeshLab 2016.12 the old
   one stayed current.

7. Grow Points (line 15)
   In Python: generate_grown_points
   Move points away from the origin.
   Works on the current layer.
   With:
   - keep = yes: Keep
   Not given, so left at the defaults: factor = 2, randomseed = 0, mode =
   'plain', title = 'grown'.
   Its comment: done

It has 2 mistakes, so it does not run.
"""


def of(*steps):
    script = FilterScript()
    for name, values in steps:
        script = script.with_step(name, **values)
    return script.explained()


def test_a_whole_script_with_its_mistakes(tmp_path, installed):
    path = tmp_path / "old.mlx"
    path.write_text(OLD)
    script = read_script(path)
    heading, _, rest = explained(script, matched(script)).partition("\n\n")
    assert "".join(heading.split()) == f"{path}:7steps,inthisorder.".replace(" ", "")
    assert rest == WORDS


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        ("set_color_per_vertex", {"color1": (255, 0, 9)},
         "- color1 = red 255, green 0, blue 9 of 255\n"),
        ("set_color_per_vertex", {"color1": (255, 0, 9, 51)},
         "- color1 = red 255, green 0, blue 9 of 255, opacity 20%\n"),
        ("meshing_merge_close_vertices", {"threshold": pymeshlab.PercentageValue(2.5)},
         "- Threshold = 2.5 % of the box's diagonal\n"),
        ("meshing_merge_close_vertices", {"threshold": 0.1}, "- Threshold = 0.1\n"),
        ("compute_matrix_from_rotation", {"customaxis": (0, 0.1, 1)},
         "- customAxis = (0, 0.1, 1)\n"),
        ("set_matrix", {"transformmatrix": np.eye(4)}, "= the matrix that moves nothing\n"),
        ("set_matrix", {"transformmatrix": np.diag([2.0, 2, 2, 1])},
         "= the matrix with the rows (2, 0, 0, 0), (0, 2, 0, 0), (0,\n     0, 2, 0), (0,"),
        ("set_mesh_name", {"newname": "head"}, "- newName = 'head'\n"),
        ("meshing_repair_non_manifold_edges", {"method": 1}, "- method = 'Split Vertices'\n"),
        ("compute_matrix_from_translation", {"alllayers": True}, "   Works on every layer.\n"),
        ("create_cube", {"size": 2}, "Makes a new layer: cube.\n   With:\n   - size = 2\n"),
        ("get_hausdorff_distance", {},
         "Not given, so MeshLab picks the layer: SampledMesh, TargetMesh.\n"),
        ("meshing_remove_unreferenced_vertices", {},
         "   A cloud without faces would lose every point, so it is refused for one.\n"),
        ("meshing_merge_close_vertices", {},
         "Not given, so chosen when it runs: Threshold.\n"),
    ],
)  # fmt: skip
def test_values_in_words(name, values, words):
    assert words in of((name, values))


@pytest.mark.parametrize(
    ("attributes", "words"),
    [
        ('min="0" max="8"', "- Threshold = 2 (25 % of 8, the size it was made for)"),
        ('min="-1" max="8"', "- Threshold = 2\n"),
        ('min="0" max="0"', "- Threshold = 2\n"),
        ('min="0" max="wide"', "- Threshold = 2\n"),
        ('min="0" max="4.0"', "- Threshold = 2\n"),  # what our own writer puts for want of one
        ("", "- Threshold = 2\n"),
    ],
)
def test_shares_are_told_where_the_range_is_one(tmp_path, attributes, words):
    param = f'<Param type="RichAbsPerc" name="Threshold" value="2" {attributes}/>'
    path = tmp_path / "a.mlx"
    path.write_text(f'<FilterScript><filter name="Merge Close Vertices">{param}</filter>'
                    "</FilterScript>")  # fmt: skip
    assert words in FilterScript.read(path).explained()


def test_which_layer_stays_current():
    steps = [("generate_surface_reconstruction_screened_poisson", {}), ("delete_current_mesh", {})]
    words = "That layer stays the current one; what is made is a layer beside it.\n"
    assert words in of(*steps)
    assert words not in of(*steps[:1])


def test_every_filter_of_meshlab_has_a_sentence():
    for name in native_filters():
        sentence = sentence_of(name)
        assert sentence.endswith(".")
        assert "_" not in sentence
        assert sentence[0].isupper()
        verb = name.split("_")[0] + "_"
        assert verb in BEGINNINGS or verb in ("nxs_", "raster_"), name


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("compute_selection_by_color_per_face", "Selects by color, for each face."),
        ("meshing_remove_null_faces", "Removes null faces."),
        ("get_hausdorff_distance", "Measures, and changes nothing: Hausdorff distance."),
        ("raster_global_refinement_mutual_information",
         "Raster global refinement mutual information."),
        ("set_matrix", "Sets matrix."),
    ],
)  # fmt: skip
def test_sentences(name, sentence):
    assert sentence_of(name) == sentence


def test_an_empty_script_and_one_made_in_memory():
    assert FilterScript().explained() == "script: 0 steps, in this order.\n"
    assert (
        FilterScript((Step("Close Holes", 0),))
        .explained()
        .startswith(
            "script: 1 step, in this order.\n\n1. Close Holes\n   In Python: meshing_close_holes\n"
        )
    )
    one = FilterScript((Step("Zzz", 0),)).explained()
    assert one.endswith("\n\nIt has 1 mistake, so it does not run.\n")
