"""Detect Reflection Planes on documents: planes drawn by hand, and a selection that helps."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest
import shapes

from meshlab_symrecon import apply_filter
from meshlab_symrecon.errors import GeometryError, ParameterError, SymReconWarning
from meshlab_symrecon.geometry.bounds import box_diagonal
from meshlab_symrecon.geometry.plane_quads import PLANES_LABEL, planes_as_quads, planes_of_pieces
from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.host.meshset import add_layer, read_layer
from meshlab_symrecon.plugin import Layer

DETECT, COMPLETE = "generate_reflection_planes", "generate_mirror_completed_points"
NO_FACES = np.zeros((0, 3), dtype=np.int64)
PLACED = shapes.MOTIONS[-1]  # turned, shifted and scaled: no axis or origin can help
STATUE = PLACED(shapes.statue(1500, seed=5))
(TRUE,) = PLACED.planes(np.array([[1.0, 0.0, 0.0, 0.0]]))
DIAGONAL = box_diagonal(STATUE)


def rock(count: int, seed: int = 3) -> np.ndarray:
    """A boulder without any symmetry, twice as large as the statue, under it and to one side."""
    rng = np.random.default_rng(seed)
    sphere = rng.normal(size=(count, 3))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    radius = np.ones(count)
    for _ in range(12):
        centre = rng.normal(size=3)
        centre /= np.linalg.norm(centre)
        width, height = rng.uniform(0.2, 0.7), rng.uniform(-0.3, 0.8)
        radius += height * np.exp(-(((sphere - centre) / width) ** 2).sum(axis=1))
    return PLACED(2.0 * sphere * radius[:, None] * [1.3, 1.0, 0.8] + [1.5, -2.5, -2.0])


BOTH = np.concatenate([STATUE, rock(3000)])  # the statue first


def document(points: np.ndarray, faces: np.ndarray = NO_FACES) -> pymeshlab.MeshSet:
    mesh_set = pymeshlab.MeshSet(verbose=False)
    add_layer(mesh_set, Layer(points, faces, "scan"), current=True)
    return mesh_set


def draw(mesh_set: pymeshlab.MeshSet, planes: np.ndarray, label: str = PLANES_LABEL) -> int:
    corners, faces = planes_as_quads(np.atleast_2d(planes), STATUE)
    return add_layer(mesh_set, Layer(corners, faces, label), current=False)


def by_hand(plane: np.ndarray, degrees: float = 8.0, shift: float = 0.03) -> np.ndarray:
    """A plane turned about the middle of the statue, and shifted by a share of its diagonal."""
    middle = STATUE.mean(axis=0)
    aside = np.cross(plane[:3], [0.6, 0.0, 0.8])
    angle = np.radians(degrees)
    normal = np.cos(angle) * plane[:3] + np.sin(angle) * aside / np.linalg.norm(aside)
    offset = plane @ np.append(middle, 1.0) - normal @ middle + shift * DIAGONAL
    return np.append(normal, offset)


def errors(found: np.ndarray, true: np.ndarray = TRUE) -> tuple[float, float]:
    """Degrees and shares of the diagonal between two planes, at the middle of the statue."""
    facing = np.sign(found[:3] @ true[:3])
    degrees = np.degrees(np.arcsin(np.linalg.norm(np.cross(found[:3], true[:3]))))
    apart = (facing * found - true) @ np.append(STATUE.mean(axis=0), 1.0)
    return float(degrees), abs(float(apart)) / DIAGONAL


def assert_true(plane: np.ndarray) -> None:
    degrees, apart = errors(plane)
    assert degrees < 0.5
    assert apart < 0.005


def refined(mesh_set: pymeshlab.MeshSet, **values: object) -> dict[str, np.ndarray]:
    return apply_filter(mesh_set, DETECT, refine=True, minconfidence=0.0, **values)


def bytes_of(mesh_set: pymeshlab.MeshSet, number: int) -> tuple[bytes, bytes]:
    mesh = mesh_set.mesh(number)
    return mesh.vertex_matrix().tobytes(), mesh.face_matrix().tobytes()


def select_statue(mesh_set: pymeshlab.MeshSet) -> None:
    mesh_set.compute_selection_by_condition_per_vertex(condselect=f"vi < {len(STATUE)}")


# --- planes drawn by hand -------------------------------------------------------------------------


def test_the_drawing_is_as_wrong_as_it_says():
    assert errors(by_hand(TRUE)) == pytest.approx((8.0, 0.03))


def test_a_drawn_plane_is_moved_to_the_true_one_and_the_completion_takes_it():
    mesh_set = document(STATUE)
    drawn = draw(mesh_set, by_hand(TRUE))
    before = [bytes_of(mesh_set, number) for number in (0, drawn)]
    found = refined(mesh_set)
    assert found["planes"].shape == (1, 4)
    assert_true(found["planes"][0])
    assert [bytes_of(mesh_set, number) for number in (0, drawn)] == before
    assert mesh_set.current_mesh_id() == 0
    assert mesh_set.mesh_number() == 3

    sheet = read_layer(mesh_set, 2)
    assert sheet.label.startswith(PLANES_LABEL)
    np.testing.assert_allclose(planes_of_pieces(sheet.points, sheet.faces)[0, :3],
                               found["planes"][0, :3], atol=1e-9)  # fmt: skip
    np.testing.assert_array_equal(sheet.face_quality, np.repeat(found["confidence"], 2))

    with pytest.warns(SymReconWarning, match="the scan has no normals"):
        assert apply_filter(mesh_set, COMPLETE, blend=0.0)["mirrored"] > 0
    added = mesh_set.current_mesh().vertex_matrix()[len(STATUE) :]
    images = reflect(STATUE, found["planes"][0])
    gaps = np.abs(added[:, None] - images[None]).sum(axis=2).min(axis=1)
    assert gaps.max() < 1e-9 * DIAGONAL


def test_a_plane_that_was_moved_by_its_matrix_is_refined_where_it_is_seen():
    mesh_set = document(STATUE)
    middle, aside = STATUE.mean(axis=0), np.cross(TRUE[:3], [0.6, 0.0, 0.8])
    aside /= np.linalg.norm(aside)
    cross = np.cross(np.eye(3), aside).T
    turn = np.eye(3) + np.sin(0.14) * cross + (1.0 - np.cos(0.14)) * cross @ cross
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, middle - turn @ middle
    drawn = draw(mesh_set, TRUE)
    mesh_set.set_current_mesh(drawn)
    mesh_set.set_matrix(transformmatrix=matrix, freeze=False)
    mesh_set.set_current_mesh(0)
    sheet = read_layer(mesh_set, drawn)
    assert errors(planes_of_pieces(sheet.points, sheet.faces)[0])[0] == pytest.approx(8.02, abs=0.1)
    assert_true(refined(mesh_set)["planes"][0])


def test_a_plane_that_meshlab_fits_to_some_points_of_the_middle_is_refined():
    mesh_set = document(STATUE)
    near = np.flatnonzero(np.abs(STATUE @ TRUE[:3] + TRUE[3]) < 0.02 * DIAGONAL)[:6]
    condition = " || ".join(f"vi == {index}" for index in near)
    mesh_set.compute_selection_by_condition_per_vertex(condselect=condition)
    mesh_set.generate_plane_fitting_to_selection()
    fitted = mesh_set.current_mesh_id()
    mesh_set.set_current_mesh(0)
    sheet = read_layer(mesh_set, fitted)
    assert errors(planes_of_pieces(sheet.points, sheet.faces)[0])[0] > 0.5
    assert_true(refined(mesh_set, planes=fitted)["planes"][0])


@pytest.mark.parametrize("motion", shapes.MOTIONS, ids=lambda motion: motion.name)
def test_refining_follows_rotation_translation_and_scale(motion):
    mesh_set = document(motion(STATUE))
    (drawn,) = motion.planes(by_hand(TRUE)[None])
    corners, faces = planes_as_quads(drawn[None], motion(STATUE))
    add_layer(mesh_set, Layer(corners, faces, PLANES_LABEL), current=False)
    turn = np.column_stack([motion.scale * motion.turn, motion.shift])
    back = refined(mesh_set)["planes"][0] @ np.vstack([turn, [0.0, 0.0, 0.0, 1.0]])
    assert_true(back / np.linalg.norm(back[:3]))


def test_planes_are_refined_in_their_order_and_none_is_lost():
    mesh_set = document(STATUE)
    (across,) = PLACED.planes(np.array([[0.0, 0.0, 1.0, 0.0]]))
    draw(mesh_set, np.stack([across, by_hand(TRUE)]))
    found = refined(mesh_set)
    assert found["planes"].shape == (2, 4)
    assert_true(found["planes"][1])
    assert errors(found["planes"][0], across)[0] < 20.0
    assert found["support"][1] > found["support"][0]


def test_only_the_first_planes_are_refined_when_asked_and_a_warning_says_so():
    mesh_set = document(STATUE)
    (across,) = PLACED.planes(np.array([[0.0, 0.0, 1.0, 0.0]]))
    draw(mesh_set, np.stack([by_hand(TRUE), across]))
    with pytest.warns(SymReconWarning, match="has 2 planes, of which the first 1 were refined"):
        found = refined(mesh_set, maxplanes=1)
    assert found["planes"].shape == (1, 4)
    assert_true(found["planes"][0])


def test_the_planes_to_refine_can_be_named_by_number():
    mesh_set = document(STATUE)
    chosen = draw(mesh_set, by_hand(TRUE), "my drawing")
    draw(mesh_set, PLACED.planes(np.array([[0.0, 0.0, 1.0, 0.0]])))
    assert_true(refined(mesh_set, planes=chosen)["planes"][0])
    assert errors(refined(mesh_set)["planes"][0])[0] < 1.0  # now the newest is the refined one


def test_doubts_about_a_drawn_plane_are_told_and_it_is_kept():
    mesh_set = document(STATUE)
    draw(mesh_set, by_hand(TRUE))
    with pytest.warns(SymReconWarning, match=r"do not bear out, .* below 1: 0 \(0\.\d\d\); look"):
        found = apply_filter(mesh_set, DETECT, refine=True, minconfidence=1.0)
    assert len(found["planes"]) == 1
    assert mesh_set.mesh_number() == 3


@pytest.mark.parametrize("name", [PLANES_LABEL, "drawn in MeshLab"])
def test_planes_survive_a_file_and_are_refined_from_there(name, tmp_path):
    mesh_set = document(STATUE)
    mesh_set.set_current_mesh(draw(mesh_set, by_hand(TRUE)))
    mesh_set.save_current_mesh(str(tmp_path / f"{name}.ply"))
    mesh_set.set_current_mesh(0)
    direct = refined(mesh_set)

    again = document(STATUE)
    again.load_new_mesh(str(tmp_path / f"{name}.ply"))
    number = again.current_mesh_id()
    again.set_current_mesh(0)
    from_file = refined(again, planes=-1 if name == PLANES_LABEL else number)
    np.testing.assert_allclose(from_file["planes"], direct["planes"], rtol=1e-6)


# --- a selection ----------------------------------------------------------------------------------


def test_a_selection_is_looked_at_as_if_it_were_alone():
    together, alone = document(BOTH), document(STATUE)
    select_statue(together)
    values = {"minconfidence": 0.0, "maxplanes": 3}
    found = apply_filter(together, DETECT, onlyselected=True, **values)
    expected = apply_filter(alone, DETECT, **values)
    for name, value in expected.items():
        np.testing.assert_array_equal(found[name], value)
    assert_true(found["planes"][0])
    corners = together.mesh(1).vertex_matrix()
    np.testing.assert_allclose(corners, planes_as_quads(found["planes"], BOTH)[0])


def test_what_disturbs_it_outside_the_selection_is_left_out():
    mesh_set = document(BOTH)
    select_statue(mesh_set)
    with_rock = apply_filter(mesh_set, DETECT, minconfidence=0.0, maxplanes=1)
    assert errors(with_rock["planes"][0])[0] > 10.0  # degrees
    chosen = apply_filter(mesh_set, DETECT, minconfidence=0.0, maxplanes=1, onlyselected=True)
    assert_true(chosen["planes"][0])
    assert chosen["support"][0] > with_rock["support"][0]


def test_a_drawn_plane_is_refined_against_the_selection():
    mesh_set = document(BOTH)
    select_statue(mesh_set)
    drawn = draw(mesh_set, by_hand(TRUE))
    chosen = refined(mesh_set, onlyselected=True, planes=drawn)
    alone = document(STATUE)
    draw(alone, by_hand(TRUE))
    np.testing.assert_array_equal(chosen["planes"], refined(alone)["planes"])
    assert_true(chosen["planes"][0])
    against_all = refined(mesh_set, planes=drawn)
    assert chosen["support"][0] > against_all["support"][0]


def test_the_corners_of_selected_faces_count_on_a_mesh():
    points, faces = shapes.torus_mesh(60, 30)
    bent = points + 0.4 * np.outer(points[:, 0] > 0.0, [0.0, 0.2, 1.0]) * points[:, :1] ** 2
    half = points[:, 0] < 0.01
    measures = []
    for kind in ("face", "vert"):
        mesh_set = document(bent, faces)
        if kind == "face":
            condition = "x0 < 0.01 && x1 < 0.01 && x2 < 0.01"
            mesh_set.compute_selection_by_condition_per_face(condselect=condition)
            assert mesh_set.current_mesh().selected_vertex_number() == 0
        else:
            mesh_set.compute_selection_by_condition_per_vertex(condselect="x < 0.01")
        values = {"onlyselected": True, "minconfidence": 0.0}
        measures.append(apply_filter(mesh_set, DETECT, **values))
        np.testing.assert_array_equal(read_layer(mesh_set, 0).selection, half)
    np.testing.assert_array_equal(measures[0]["planes"], measures[1]["planes"])
    assert len(measures[0]["planes"])


# --- mistakes -------------------------------------------------------------------------------------


def refused(mesh_set: pymeshlab.MeshSet, kind: type[Exception], **values: object) -> str:
    layers = [bytes_of(mesh_set, mesh.id()) for mesh in mesh_set]
    with pytest.raises(kind) as caught:
        apply_filter(mesh_set, DETECT, **values)
    assert [bytes_of(mesh_set, mesh.id()) for mesh in mesh_set] == layers
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_without_a_selection_there_is_nothing_to_look_at():
    said = refused(document(STATUE), GeometryError, onlyselected=True)
    assert said == (
        "onlyselected needs a selection; layer 'scan' has none; select what the filter shall "
        "look at, or set onlyselected to false"
    )


@pytest.mark.parametrize("condition", ["vi < 4", "z == 0"], ids=["four points", "flat"])
def test_too_small_a_selection(condition):
    flat = np.column_stack([np.random.default_rng(0).random((30, 2)), np.zeros(30)])
    mesh_set = document(np.concatenate([STATUE, flat]))
    mesh_set.compute_selection_by_condition_per_vertex(condselect=condition)
    count = 4 if condition == "vi < 4" else 30
    said = refused(mesh_set, GeometryError, onlyselected=True)
    assert f"got {count} selected points of 1530 in layer 'scan'; select more" in said


def test_a_point_that_is_no_number_is_told_even_outside_the_selection():
    mesh_set = document(np.concatenate([STATUE, [[np.nan, 0.0, 0.0]]]))
    mesh_set.compute_selection_by_condition_per_vertex(condselect="vi < 1000")
    said = refused(mesh_set, GeometryError, onlyselected=True)
    assert "got 1 rows with NaN or infinity, the first at index 1500" in said


def test_a_layer_to_refine_without_refining():
    mesh_set = document(STATUE)
    said = refused(mesh_set, ParameterError, planes=draw(mesh_set, TRUE))
    assert "but refine is false; got planes=1; set refine to true" in said


def test_nothing_to_refine():
    mesh_set = document(STATUE)
    assert "no layer is called 'reflection planes'; draw a rectangle" in refused(
        mesh_set, GeometryError, refine=True
    )
    said = refused(mesh_set, ParameterError, refine=True, planes=9)
    assert said == "no layer has the number 9; the document has 0 'scan'"


def test_planes_without_faces():
    mesh_set = document(STATUE)
    add_layer(mesh_set, Layer(STATUE[:4], NO_FACES, PLANES_LABEL), current=False)
    said = refused(mesh_set, GeometryError, refine=True)
    assert "has no faces; detect planes first, or draw one" in said


@pytest.mark.parametrize("named", [True, False])
def test_the_planes_as_the_current_layer(named):
    mesh_set = document(STATUE)
    drawn = draw(mesh_set, TRUE)
    mesh_set.set_current_mesh(drawn)
    said = refused(mesh_set, GeometryError, refine=True, planes=drawn if named else -1)
    assert "got layer 1 'reflection planes', which it reads beside the scan; make" in said


def test_a_drawing_that_is_no_plane():
    mesh_set = document(STATUE)
    corners, faces = planes_as_quads(TRUE[None], STATUE)
    corners[0] += 0.1 * DIAGONAL * TRUE[:3]
    add_layer(mesh_set, Layer(corners, faces, PLANES_LABEL), current=False)
    assert "must be a flat patch" in refused(mesh_set, GeometryError, refine=True)
