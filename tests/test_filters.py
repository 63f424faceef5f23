"""What our filters make of layers, beside what holds for every filter."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import shapes
from scipy.spatial import cKDTree

from meshlab_symrecon import provenance
from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.filters import mirror_completed_points, power_crust
from meshlab_symrecon.geometry.plane_quads import PLANES_LABEL, planes_as_quads
from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.plugin import Layer, Layers
from meshlab_symrecon.provenance import paint_by_share

NO_FACES = np.zeros((0, 3), dtype=np.int64)
X, Y = np.array([1.0, 0, 0, 0]), np.array([0, 1.0, 0, 0])
SPHERE = shapes.fibonacci_sphere(1500)
HALF = SPHERE[SPHERE[:, 0] < 0.0]
QUARTER = HALF[HALF[:, 1] < 0.0]


def planes_layer(planes: np.ndarray, identifier: int, label: str = PLANES_LABEL) -> Layer:
    corners, faces = planes_as_quads(np.atleast_2d(planes), SPHERE)
    return Layer(corners, faces, label=label, identifier=identifier)


def document(*layers: Layer) -> Layers:
    """Return a document whose current layer is number 0, the first of these."""
    by_number = {layer.identifier: layer for layer in layers}
    labels = {number: layer.label for number, layer in by_number.items()}
    return Layers(labels, 0, by_number.__getitem__)


def scan(points: np.ndarray, **attributes: np.ndarray) -> Layer:
    return Layer(points, NO_FACES, label="scan", identifier=0, **attributes)


def completed(layers: Layers, **values: object) -> Layer:
    (made,) = mirror_completed_points.FILTER.apply(layers, values).layers
    return made


def test_the_newest_layer_of_planes_counts():
    layers = document(
        scan(HALF), planes_layer(Y, 1), planes_layer(X, 2, f"{PLANES_LABEL}(1)"),
        planes_layer(Y, 3, "something else"),
    )  # fmt: skip
    made = completed(layers)
    added = made.points[len(HALF) :]
    assert (added[:, 0] > 0.0).all()
    assert len(made.points) > 0.9 * len(SPHERE)


def test_a_layer_of_planes_can_be_named_by_its_number():
    layers = document(scan(HALF), planes_layer(X, 1, "by hand"), planes_layer(Y, 2))
    assert (completed(layers, planes=1).points[len(HALF) :, 0] > 0.0).all()
    with pytest.raises(ParameterError, match="no layer has the number 7"):
        completed(layers, planes=7)


def test_only_the_first_planes_are_used_when_asked():
    layers = document(scan(QUARTER), planes_layer(np.stack([X, Y]), 1))
    first, both = completed(layers, maxplanes=1), completed(layers)
    assert (first.points[:, 1] < 0.0).all()
    assert len(first.points) < 0.6 * len(SPHERE)
    assert len(both.points) > 0.85 * len(SPHERE)


def test_mirrored_points_carry_mirrored_normals_and_are_marked():
    colours = np.column_stack([np.abs(HALF), np.ones(len(HALF))])
    made = completed(document(scan(HALF, normals=HALF, colours=colours), planes_layer(X, 1)))
    count = len(HALF)
    assert np.array_equal(made.points[:count], HALF)
    np.testing.assert_allclose(made.normals, made.points, atol=1e-12)  # outward on a sphere
    np.testing.assert_allclose(made.colours[:, :3], np.abs(made.points), atol=1e-12)
    assert np.array_equal(made.quality, np.arange(len(made.points)) >= count)
    assert np.array_equal(made.attributes["mirrored"], made.quality)
    images = {tuple(row) for row in reflect(HALF, X).tolist()}
    assert {tuple(row) for row in made.points[count:].tolist()} <= images


def test_without_planes_the_completion_says_what_to_do():
    outcome = mirror_completed_points.FILTER.apply(document(scan(HALF)), {})
    assert f"no layer '{PLANES_LABEL}'" in outcome.warnings[0]
    assert np.array_equal(outcome.layers[0].points, HALF)
    assert not outcome.layers[0].quality.any()
    counts = {name: outcome.measures[name] for name in ("measured", "mirrored", "scattered")}
    assert counts == {"measured": len(HALF), "mirrored": 0, "scattered": 0}
    bare = Layer(SPHERE[:4], NO_FACES, label=PLANES_LABEL, identifier=1)
    with pytest.raises(GeometryError, match="has no faces; detect planes first"):
        completed(document(scan(HALF), bare))


def test_only_the_selected_points_are_mirrored_and_the_others_still_count_as_measured():
    low = HALF[:, 2] < 0.0
    layers = document(scan(HALF, selected=low), planes_layer(X, 1))
    chosen, everything = (completed(layers, onlyselected=only, blend=0.0) for only in (True, False))
    assert (chosen.points[len(HALF) :, 2] < 0.0).all()
    added = everything.points[len(HALF) :]
    np.testing.assert_array_equal(chosen.points[len(HALF) :], added[added[:, 2] < 0.0])
    hole = SPHERE[np.linalg.norm(SPHERE - [0.8, 0.6, 0.0], axis=1) > 0.4]
    selected = np.linalg.norm(hole - [-0.8, 0.6, 0.0], axis=1) < 0.5
    layers = document(scan(hole, selected=selected), planes_layer(X, 1))
    made = completed(layers, onlyselected=True, blend=0.0)
    np.testing.assert_array_equal(made.points, completed(layers, blend=0.0).points)


def test_without_a_selection_only_selected_says_what_to_do():
    layers = document(scan(HALF), planes_layer(X, 1))
    with pytest.raises(GeometryError) as caught:
        completed(layers, onlyselected=True)
    assert str(caught.value) == (
        "onlyselected needs a selection; layer 'scan' has none; select what the filter shall "
        "look at, or set onlyselected to false"
    )


def test_one_plane_of_several_can_be_chosen_by_its_number():
    layers = document(scan(QUARTER), planes_layer(np.stack([X, Y]), 1))
    for number, plane in enumerate([X, Y]):
        alone = document(scan(QUARTER), planes_layer(plane, 1))
        chosen = completed(layers, plane=number, maxplanes=1)
        np.testing.assert_array_equal(chosen.points, completed(alone).points)
    with pytest.raises(ParameterError) as caught:
        completed(layers, plane=2)
    assert str(caught.value) == (
        "plane must be the number of a plane of layer 'reflection planes', 0 to 1; got 2; "
        "use -1 for all"
    )


def test_planes_compose_round_the_whole_group_of_a_star():
    """A sixth of a star, doubled, doubled and doubled: planes at 60, 120 and 0 degrees."""

    def radius(points):
        turn = np.arctan2(points[:, 1], points[:, 0])
        return 1.0 + 0.2 * np.cos(6.0 * turn) * (1.0 - points[:, 2] ** 2)

    star, turn = SPHERE * radius(SPHERE)[:, None], np.arctan2(SPHERE[:, 1], SPHERE[:, 0])
    angles = np.radians([60.0, 120.0, 0.0])
    normals = np.stack([-np.sin(angles), np.cos(angles), 0 * angles, 0 * angles], axis=1)
    sixth = star[(turn > 0.0) & (turn < np.pi / 3.0)]
    layers = document(scan(sixth), planes_layer(normals, 1))
    counts = [len(completed(layers, maxplanes=count, blend=0.0).points) for count in (1, 2, 3)]
    assert np.all(np.diff(counts, prepend=len(sixth)) > 0)
    whole = completed(layers, blend=0.0).points
    assert cKDTree(whole).query(star)[0].max() < 0.2
    lengths = np.linalg.norm(whole, axis=1)
    np.testing.assert_allclose(lengths, radius(whole / lengths[:, None]), atol=1e-9)


def test_paint_shows_what_was_invented_instead_of_the_colours_of_the_scan():
    colours = np.tile([0.2, 0.4, 0.6, 1.0], (len(HALF), 1))
    layers = document(scan(HALF, colours=colours), planes_layer(X, 1))
    painted, plain = completed(layers, paint=True), completed(layers)
    expected = np.where(painted.quality[:, None] == 0.0, provenance.MEASURED, provenance.INVENTED)
    np.testing.assert_array_equal(painted.colours[:, :3], expected / 255.0)
    assert (painted.colours[:, 3] == 1.0).all()
    np.testing.assert_array_equal(plain.colours, np.tile(colours[0], (len(plain.points), 1)))
    bare = completed(document(scan(HALF), planes_layer(X, 1)), paint=True)
    np.testing.assert_array_equal(bare.colours, painted.colours)


def test_the_crust_can_be_painted_by_its_share_invented():
    share = (SPHERE[:, 0] > 0.0).astype(float)
    layers = document(scan(SPHERE, quality=share))
    surface = power_crust.FILTER.apply(layers, {"paint": True}).layers[0]
    np.testing.assert_array_equal(surface.colours, provenance.paint_by_share(surface.quality))
    clear = np.abs(surface.points[:, 0]) > 0.2
    right = surface.points[clear, :1] > 0.0
    expected = np.where(right, provenance.INVENTED, provenance.MEASURED) / 255.0
    np.testing.assert_array_equal(surface.colours[clear, :3], expected)


def test_custom_scalars_follow_their_points_and_keep_their_names():
    height, number = HALF[:, 2].copy(), np.arange(float(len(HALF)))
    source = scan(HALF, quality=1.0 + HALF[:, 1], attributes={"height": height, "number": number})
    made = completed(document(source, planes_layer(X, 1)), blend=0.0)
    assert set(made.attributes) == {"height", "number", "scan_quality", "mirrored"}
    of = made.attributes["number"].astype(int)
    np.testing.assert_array_equal(of[: len(HALF)], np.arange(len(HALF)))
    np.testing.assert_array_equal(made.points[len(HALF) :], reflect(HALF[of[len(HALF) :]], X))
    np.testing.assert_array_equal(made.attributes["height"], height[of])
    np.testing.assert_array_equal(made.attributes["scan_quality"], 1.0 + HALF[of, 1])


@pytest.mark.parametrize("plane", [[0.6, 0.0, 0.8, 0.0], [0.48, 0.6, 0.64, 0.0]])
def test_outward_normals_stay_outward_where_triangles_are_turned_round(plane):
    """The determinant of a reflection is -1: a triangle's corners turn round, its normal not."""
    plane = np.array(plane)
    half = SPHERE[SPHERE @ plane[:3] < 0.0]
    made = completed(document(scan(half, normals=half), planes_layer(plane, 1)), blend=0.0)
    np.testing.assert_allclose(made.normals, made.points, atol=1e-9)
    a, b, c = half[:3]
    if np.cross(b - a, c - a) @ a < 0.0:
        b, c = c, b
    a, b, c = reflect(np.stack([a, b, c]), plane)
    assert np.cross(b - a, c - a) @ a < 0.0


def test_a_scan_without_normals_is_told_of():
    layers = document(scan(HALF), planes_layer(X, 1))
    outcome = mirror_completed_points.FILTER.apply(layers, {})
    assert outcome.warnings == (mirror_completed_points.NO_NORMALS,)
    layers = document(scan(HALF, normals=HALF), planes_layer(X, 1))
    assert mirror_completed_points.FILTER.apply(layers, {}).warnings == ()


def test_what_is_open_on_both_sides_is_measured():
    sphere = shapes.fibonacci_sphere(4000)
    above = sphere[sphere[:, 2] < np.cos(0.6)]
    hole = np.linalg.norm(above - [0.8, 0.0, -0.6], axis=1) < 0.3
    layers = document(scan(above[~hole]), planes_layer(X, 1))
    measures = mirror_completed_points.FILTER.apply(layers, {}).measures
    (rim,) = measures["open_rims"]
    np.testing.assert_allclose(rim, [0, 0, np.cos(0.6), 2 * np.sin(0.6)], atol=0.12)
    assert measures["mirrored"] == pytest.approx(hole.sum(), rel=0.3)
    assert (measures["scattered"], measures["plinth"]) == (0, 0)


def test_the_planes_themselves_are_no_scan():
    sheet = dataclasses.replace(planes_layer(X, 0), label="reflection planes")
    with pytest.raises(GeometryError, match="got layer 0 'reflection planes', which"):
        completed(document(sheet))


def test_the_crust_takes_colours_and_quality_from_the_nearest_samples():
    share = (SPHERE[:, 0] > 0.0).astype(float)
    colours = np.column_stack([share, 1.0 - share, np.zeros(len(SPHERE)), np.ones(len(SPHERE))])
    outcome = power_crust.FILTER.apply(document(scan(SPHERE, quality=share, colours=colours)), {})
    (surface,) = outcome.layers
    clear = np.abs(surface.points[:, 0]) > 0.2
    np.testing.assert_allclose(surface.quality[clear], surface.points[clear, 0] > 0.0, atol=1e-12)
    np.testing.assert_allclose(surface.colours[:, 0], surface.quality, atol=1e-12)
    np.testing.assert_allclose(surface.colours[:, 3], 1.0, atol=1e-12)
    plain = power_crust.FILTER.apply(document(scan(SPHERE)), {}).layers[0]
    assert plain.quality is None
    assert plain.colours is None
    assert np.array_equal(plain.points, surface.points)


def test_the_medial_axis_of_a_sphere_is_its_centre():
    outcome = power_crust.FILTER.apply(document(scan(SPHERE)), {"medialaxis": True})
    surface, axis = outcome.layers
    assert (surface.label, axis.label) == (power_crust.LABEL, power_crust.AXIS_LABEL)
    assert outcome.current == 0
    assert np.linalg.norm(axis.points, axis=1).max() < 0.01
    np.testing.assert_allclose(axis.quality, 1.0, atol=0.01)


def test_a_handful_of_points_gets_its_hull_and_a_warning():
    box = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    outcome = power_crust.FILTER.apply(document(scan(box)), {})
    assert outcome.warnings == (power_crust.HULL_WARNING,)
    assert outcome.measures["closed"]
    assert len(outcome.layers[0].points) == 8


def test_paint_goes_by_what_a_completion_has_marked():
    share = (SPHERE[:, 0] > 0.0).astype(float)
    marked = dataclasses.replace(scan(SPHERE, quality=SPHERE[:, 2]), attributes={"mirrored": share})
    (painted,) = power_crust.FILTER.apply(document(marked), {"paint": True}).layers
    clear = np.abs(painted.points[:, 0]) > 0.2
    expected = paint_by_share((painted.points[clear, 0] > 0.0).astype(float))
    np.testing.assert_allclose(painted.colours[clear], expected, atol=1e-12)
    with pytest.raises(GeometryError, match="paint needs quality from 0"):
        power_crust.FILTER.apply(document(scan(SPHERE, quality=SPHERE[:, 2])), {"paint": True})
    (bare,) = power_crust.FILTER.apply(document(scan(SPHERE)), {"paint": True}).layers
    np.testing.assert_allclose(
        bare.colours, np.tile(paint_by_share(np.zeros(1)), (len(bare.points), 1))
    )
