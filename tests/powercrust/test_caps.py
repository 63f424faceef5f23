"""Caps over holes of the scan, and trimming them off."""

import numpy as np
import pytest
import shapes

from meshlab_symrecon.geometry.surfaces import topology
from meshlab_symrecon.geometry.triangulation import delaunay, regular_triangulation
from meshlab_symrecon.powercrust.caps import Caps, farthest_points, find_caps
from meshlab_symrecon.powercrust.crust import crust_faces
from meshlab_symrecon.powercrust.interpolating import interpolating_faces
from meshlab_symrecon.powercrust.labelling import label_poles
from meshlab_symrecon.powercrust.poles import enclose, find_poles
from meshlab_symrecon.powercrust.trimming import trim

MOST_BY_CHANCE = 7.2  # spacings; random samples of these sizes reach 7.0
CRUST, THROUGH_SAMPLES = 0.25, 0.08  # of the width of a hole: the crust's cap sinks into it


def random_sphere(count, seed, holes=()):
    """Uniform random points, but none within the given angles of the given directions."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    for direction, angle in holes:
        points = points[points @ direction < np.cos(angle)]
    return points * (1.0 + 1e-5 * rng.normal(size=(len(points), 1)))


def surfaces(samples):
    """The crust and the surface through the samples, with the spacing of the samples."""
    voronoi = delaunay(enclose(samples))
    poles = find_poles(voronoi, len(samples))
    diagram = regular_triangulation(poles.centres, poles.radii**2)
    inside = label_poles(poles, diagram).inside
    return (
        crust_faces(poles, diagram, inside),
        interpolating_faces(voronoi, poles, diagram, inside),
        poles.room,
    )


def near(surface):
    """The sample nearest to each vertex."""
    return surface.nearest if hasattr(surface, "nearest") else surface.samples


def assert_trimmed(trimmed, surface):
    shape = topology(trimmed.faces)
    assert shape.edge_manifold
    assert shape.vertex_manifold
    assert shape.oriented
    assert np.array_equal(trimmed.points, surface.points[trimmed.vertices])
    assert np.array_equal(np.unique(trimmed.faces), np.arange(len(trimmed.points)))
    old = {tuple(row) for row in surface.faces.tolist()}
    assert {tuple(row) for row in trimmed.vertices[trimmed.faces].tolist()} <= old
    # no face hangs on by a single edge
    edges = np.sort(trimmed.faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    _, edge, uses = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    assert (uses[edge.ravel()] == 1).reshape(-1, 3).sum(axis=1).max() <= 1


def rim(trimmed):
    """Points on the boundary, and the number of loops counted by walking along them."""
    ahead = {}
    sides = trimmed.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).tolist()
    there = {tuple(side) for side in sides}
    for start, end in sides:
        if (end, start) not in there:
            assert start not in ahead
            ahead[start] = end
    loops, left = 0, set(ahead)
    while left:
        loops += 1
        at = left.pop()
        while ahead[at] in left:
            at = ahead[at]
            left.remove(at)
    return trimmed.points[list(ahead)], loops


@pytest.mark.parametrize("angle", [0.25, 0.5, 1.0])
def test_a_hole_is_as_wide_as_it_is_and_opens_at_its_rim(angle):
    samples = random_sphere(4000, 3, [((0.0, 0.0, 1.0), angle)])
    *both, spacing = surfaces(samples)
    for surface, error in zip(both, (CRUST, THROUGH_SAMPLES), strict=True):
        caps = find_caps(surface.points, surface.faces, near(surface), samples, spacing)
        assert caps.widths[np.argmax(caps.multiples)] == pytest.approx(2 * np.sin(angle), rel=error)
        assert np.count_nonzero(caps.multiples > MOST_BY_CHANCE) == 1
        trimmed = trim(surface.points, surface.faces, caps, MOST_BY_CHANCE)
        assert_trimmed(trimmed, surface)
        assert trimmed.opened == trimmed.loops == 1
        at_rim, loops = rim(trimmed)
        assert loops == 1
        apart = np.arccos(at_rim[:, 2] / np.linalg.norm(at_rim, axis=1)) - angle
        assert apart.min() > -2 * np.median(spacing)
        # chance voids of the samples beside the hole go with it
        assert apart.max() < MOST_BY_CHANCE * np.median(spacing)
        shape = topology(trimmed.faces)
        assert (shape.components, shape.euler) == (1, 1)


def test_only_wide_holes_open():
    directions = [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (-1.0, 0.0, 0.0)]
    angles = [0.7, 0.5, 0.3, 0.12]
    samples = random_sphere(6000, 4, list(zip(directions, angles, strict=True)))
    *both, spacing = surfaces(samples)
    for surface, error in zip(both, (CRUST, THROUGH_SAMPLES), strict=True):
        caps = find_caps(surface.points, surface.faces, near(surface), samples, spacing)
        widest = np.sort(caps.widths)[-3:][::-1]
        np.testing.assert_allclose(widest, 2 * np.sin(angles[:3]), rtol=error)
        between = np.sort(caps.multiples)[::-1]
        for opened in range(4):
            limit = 0.5 * (between[opened] + (between[opened - 1] if opened else 99.0))
            trimmed = trim(surface.points, surface.faces, caps, limit)
            assert_trimmed(trimmed, surface)
            assert trimmed.opened == trimmed.loops == rim(trimmed)[1] == opened
            # nothing is missing over the holes that stay shut
            cosines = surface.points @ np.transpose(directions[opened:])
            cosines /= np.linalg.norm(surface.points, axis=1, keepdims=True)
            over = (cosines > np.cos(angles[opened:]))[surface.faces].any(axis=(1, 2))
            left = {tuple(row) for row in trimmed.vertices[trimmed.faces].tolist()}
            assert {tuple(row) for row in surface.faces[over].tolist()} <= left


@pytest.mark.parametrize("seed", range(2))
def test_random_samples_of_whole_bodies_have_no_wide_cap(seed):
    for samples in (
        random_sphere(2500, seed),
        shapes.torus(1500, seed=seed),
        shapes.statue(2500, seed=seed, missing=0.0),
    ):
        *both, spacing = surfaces(samples)
        for surface in both:
            caps = find_caps(surface.points, surface.faces, near(surface), samples, spacing)
            assert 0.0 < caps.largest < MOST_BY_CHANCE
            whole = trim(surface.points, surface.faces, caps, MOST_BY_CHANCE)
            assert (whole.loops, whole.opened) == (0, 0)
            assert np.array_equal(whole.faces, surface.faces)
            assert np.array_equal(whole.points, surface.points)


def test_an_even_sphere_has_no_cap_at_all():
    samples = shapes.fibonacci_sphere(1000)
    *both, spacing = surfaces(samples)
    for surface in both:
        caps = find_caps(surface.points, surface.faces, near(surface), samples, spacing)
        assert caps.largest == 0.0
        assert caps.widths.shape == (0,)
        assert (caps.region == -1).all()


def test_widths_scale_and_multiples_do_not():
    samples = random_sphere(2000, 8, [((0.0, 0.0, 1.0), 0.5)])
    _, surface, spacing = surfaces(samples)
    caps = find_caps(surface.points, surface.faces, near(surface), samples, spacing)
    larger = find_caps(
        8.0 * surface.points, surface.faces, near(surface), 8.0 * samples, 8.0 * spacing
    )
    assert np.array_equal(larger.widths, 8.0 * caps.widths)
    assert np.array_equal(larger.multiples, caps.multiples)
    assert np.array_equal(larger.region, caps.region)


def test_a_stray_sample_in_a_hole_goes_with_the_cap():
    ring = random_sphere(4000, 5, [((0.0, 0.0, 1.0), 0.7)])
    samples = np.vstack([ring, [[0.0, 0.0, 1.0]]])
    _, surface, spacing = surfaces(samples)
    spacing = np.append(spacing[:-1], np.median(spacing))  # its own says nothing
    caps = find_caps(surface.points, surface.faces, near(surface), samples, spacing)
    trimmed = trim(surface.points, surface.faces, caps, MOST_BY_CHANCE)
    assert_trimmed(trimmed, surface)
    assert trimmed.loops == 1
    assert len(samples) - 1 not in trimmed.vertices


def closed_band(rows, columns):
    points, faces = shapes.torus_mesh(rows, columns)
    return points, faces, len(faces)


@pytest.mark.parametrize("share", [0.05, 0.2, 0.5])
def test_any_faces_removed_leave_a_manifold_with_loops(share):
    """Random regions make every bow tie, ear and scrap there is."""
    points, faces, count = closed_band(30, 40)
    for seed in range(5):
        gone = np.random.default_rng(seed).random(count) < share
        region = np.where(gone, 0, -1)
        caps = Caps(region, np.array([2.0]), np.array([0.1]))
        trimmed = trim(points, faces, caps, 10.0)
        if len(trimmed.faces):
            shape = topology(trimmed.faces)
            assert shape.edge_manifold
            assert shape.vertex_manifold
            assert shape.oriented
            assert rim(trimmed)[1] == trimmed.loops
        left = {tuple(row) for row in trimmed.vertices[trimmed.faces].tolist()}
        assert not left & {tuple(row) for row in faces[gone].tolist()}
        assert np.array_equal(region, np.where(gone, 0, -1))


def test_everything_can_go():
    points, faces, count = closed_band(8, 9)
    caps = Caps(np.zeros(count, dtype=np.int64), np.array([1.0]), np.array([0.1]))
    trimmed = trim(points, faces, caps, 5.0)
    assert trimmed.points.shape == (0, 3)
    assert trimmed.faces.shape == (0, 3)
    assert (trimmed.loops, trimmed.opened) == (0, 1)


def test_farthest_points_against_a_fine_grid():
    corners = np.random.default_rng(2).normal(size=(200, 3, 3))
    faces = np.arange(600).reshape(-1, 3)
    farthest, reach = farthest_points(corners.reshape(-1, 3), faces)
    steps = 150
    shares = np.array(
        [(a, b, steps - a - b) for a in range(steps + 1) for b in range(steps + 1 - a)]
    )
    for triangle, place, distance in zip(corners, farthest, reach, strict=True):
        grid = shares / steps @ triangle
        best = np.linalg.norm(grid[:, None] - triangle[None], axis=2).min(axis=1).max()
        size = np.linalg.norm(triangle - np.roll(triangle, 1, axis=0), axis=1).max()
        assert best <= distance * (1 + 1e-9)
        assert distance < best + size / steps
        # the point lies in the triangle
        share = np.linalg.lstsq(
            np.vstack([triangle.T, np.ones(3)]), np.append(place, 1.0), rcond=None
        )[0]
        assert share.min() > -1e-9


def test_flat_triangles_have_a_farthest_point():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [4, 0, 0]])
    farthest, reach = farthest_points(points, np.array([[0, 1, 2], [1, 2, 0], [0, 0, 0]]))
    np.testing.assert_allclose(reach, [1.5, 1.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(farthest[:2], [[2.5, 0, 0]] * 2)
