"""What was invented stays known as invented, however filters are chained."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshlab_symrecon.filters.mirror_completed_points import FILTER
from meshlab_symrecon.host.files import load, new_document, save_current
from meshlab_symrecon.host.meshset import add_layer, read_layer
from meshlab_symrecon.plugin import Layer, Layers
from meshlab_symrecon.provenance import INVENTED, MEASURED, colours_by_share, paint_by_share

NO_FACES = np.zeros((0, 3), dtype=np.int64)


def complete(source, normal, **values):
    """Complete across the plane through the origin with that axis as its normal."""
    corners = np.array([[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]])
    quad = np.insert(corners, normal, 0.0, axis=1)
    known = {
        0: source,
        1: Layer(quad, np.array([[0, 1, 2], [0, 2, 3]]), label="reflection planes", identifier=1),
    }
    labels = {identifier: layer.label for identifier, layer in known.items()}
    return FILTER.apply(Layers(labels, 0, known.__getitem__), values)


def octant(count=400):
    """Return points of an eighth of a sphere of radius 5."""
    rng = np.random.default_rng(11)
    directions = np.abs(rng.normal(size=(count, 3)))
    points = 5.0 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return Layer(points, NO_FACES, label="scan", identifier=0)


def test_a_second_completion_does_not_call_invented_points_measured():
    scan = octant()
    first = complete(scan, 0)
    once = first.layers[0]
    second = complete(once, 1)
    twice = second.layers[0]
    assert first.measures["measured"] == second.measures["measured"] == len(scan.points)
    assert second.measures["mirrored"] == len(twice.points) - len(scan.points)
    assert first.measures["mirrored"] > 300 < len(twice.points) - len(once.points)
    expected = np.arange(len(twice.points)) >= len(scan.points)
    assert np.array_equal(twice.quality, expected)
    assert np.array_equal(twice.attributes["mirrored"], expected)
    assert np.array_equal(twice.points[: len(once.points)], once.points)


def test_quality_of_a_scan_is_not_taken_for_provenance():
    scan = octant()
    measured = Layer(scan.points, NO_FACES, quality=np.linspace(1.0, 2.0, len(scan.points)))
    assert complete(measured, 0).measures["measured"] == len(scan.points)


def test_own_quality_goes_on_as_scan_quality_and_an_earlier_one_is_kept():
    scan = octant()
    own = np.linspace(1.0, 2.0, len(scan.points))
    once = complete(replace(scan, quality=own), 0).layers[0]
    assert np.array_equal(once.attributes["scan_quality"][: len(own)], own)
    twice = complete(once, 1).layers[0]
    assert np.array_equal(twice.attributes["scan_quality"][: len(own)], own)
    assert len(twice.attributes["scan_quality"]) == len(twice.points)
    assert set(twice.attributes["scan_quality"]) == set(own)


def test_quality_that_was_computed_after_a_completion_is_kept_beside_provenance():
    scan = octant()
    once = complete(scan, 0).layers[0]
    height = once.points[:, 2].copy()
    second = complete(replace(once, quality=height), 1)
    twice = second.layers[0]
    assert second.measures["measured"] == len(scan.points)
    assert np.array_equal(twice.attributes["scan_quality"][: len(height)], height)


@pytest.mark.parametrize(
    ("quality", "is_provenance"),
    [([0, 0, 1, 1], True), ([0, 0, 0, 0], True), ([0, 1, 0, 1], False), ([1, 1, 1, 1], False),
     ([0, 0.5, 1, 1], False), ([1, 1, 0, 0], False), ([0, np.nan, 1, 1], False)],
)  # fmt: skip
def test_only_measured_first_and_then_invented_is_provenance(quality, is_provenance):
    scan = octant()
    quality = np.repeat(np.array(quality, dtype=float), len(scan.points) // 4)
    done = complete(replace(scan, quality=quality), 0)
    assert ("scan_quality" not in done.layers[0].attributes) == is_provenance
    invented = quality.sum() if is_provenance else 0
    assert done.measures["measured"] == len(scan.points) - invented
    assert np.isin(done.layers[0].quality, (0.0, 1.0)).all()


def test_planes_that_add_nothing_keep_what_is_known():
    once = complete(octant(), 0).layers[0]
    again = complete(once, 0)
    assert np.array_equal(again.layers[0].quality, once.quality)
    assert again.measures["mirrored"] == np.count_nonzero(once.quality)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_measured_points_and_provenance_survive_a_file_and_a_second_completion(tmp_path, kind):
    scan = octant()
    points = (scan.points * 7.3 + 0.1).astype(kind).astype(np.float64)
    shifted = points - 0.1
    once = complete(replace(scan, points=shifted), 0).layers[0]
    mesh_set = new_document()
    add_layer(mesh_set, once, current=True)
    path = save_current(mesh_set, tmp_path / "completed.ply") or tmp_path / "completed.ply"
    again = load(path)
    reloaded = read_layer(again, again.current_mesh_id())
    count = len(points)
    assert np.array_equal(reloaded.points[:count], shifted)
    assert np.array_equal(reloaded.quality, once.quality)
    quality_only = replace(reloaded, attributes={}, identifier=0)
    for known in (quality_only, replace(reloaded, identifier=0)):
        second = complete(known, 1)
        twice = second.layers[0]
        assert second.measures["measured"] == count
        assert np.array_equal(twice.points[: len(once.points)], reloaded.points)
        assert np.array_equal(twice.quality, np.arange(len(twice.points)) >= count)


def test_colours_run_from_measured_to_invented():
    painted = colours_by_share(np.array([0.0, 1.0, 0.5, -3.0, 9.0]))
    assert painted.dtype == np.uint8
    assert [tuple(row) for row in painted[:2].tolist()] == [MEASURED, INVENTED]
    assert np.abs(painted[2] - (np.array(MEASURED) + INVENTED) / 2).max() <= 0.5
    assert np.array_equal(painted[3:], painted[:2])
    layer = paint_by_share(np.array([0.0, 1.0]))
    assert np.array_equal(np.round(255 * layer[:, :3]), painted[:2])
    assert (layer[:, 3] == 1.0).all()
    assert paint_by_share(np.zeros(0)).shape == (0, 4)
