"""What our filters make of layers, beside what holds for every filter."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

from meshlab_symrecon.errors import GeometryError, ParameterError
from meshlab_symrecon.filters import mirror_completed_points, power_crust
from meshlab_symrecon.geometry.plane_quads import PLANES_LABEL, planes_as_quads
from meshlab_symrecon.geometry.planes import reflect
from meshlab_symrecon.plugin import Layer, Layers

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
