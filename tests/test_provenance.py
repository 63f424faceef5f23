"""What was invented stays known as invented, however filters are chained."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.filters.mirror_completed_points import FILTER
from meshlab_symrecon.plugin import Layer, Layers

NO_FACES = np.zeros((0, 3), dtype=np.int64)


def complete(source, normal):
    """Complete across the plane through the origin with that axis as its normal."""
    corners = np.array([[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]])
    quad = np.insert(corners, normal, 0.0, axis=1)
    known = {
        0: source,
        1: Layer(quad, np.array([[0, 1, 2], [0, 2, 3]]), label="reflection planes", identifier=1),
    }
    labels = {identifier: layer.label for identifier, layer in known.items()}
    return FILTER.apply(Layers(labels, 0, known.__getitem__), {})


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
