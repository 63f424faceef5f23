"""The surface through the samples."""

import numpy as np
import pytest
import shapes
from scipy.spatial import cKDTree

from meshlab_symrecon import _native
from meshlab_symrecon.geometry.surfaces import enclosed_volume, topology
from meshlab_symrecon.geometry.triangulation import FACETS, delaunay, regular_triangulation
from meshlab_symrecon.powercrust.interpolating import interpolating_faces
from meshlab_symrecon.powercrust.labelling import label_poles
from meshlab_symrecon.powercrust.poles import enclose, find_poles


def steps(samples):
    voronoi = delaunay(enclose(samples))
    poles = find_poles(voronoi, len(samples))
    diagram = regular_triangulation(poles.centres, poles.radii**2)
    return voronoi, poles, diagram, label_poles(poles, diagram).inside


def surface_through(samples):
    return interpolating_faces(*steps(samples))


def assert_solid(surface, components=1, genus=0):
    shape = topology(surface.faces)
    assert shape.closed
    assert shape.edge_manifold
    assert shape.vertex_manifold
    assert shape.oriented
    assert (shape.components, shape.genus) == (components, genus)
    assert enclosed_volume(surface.points, surface.faces) > 0
    assert len(np.unique(surface.faces)) == len(surface.points)


def boundary(voronoi, sides):
    inner = np.flatnonzero(sides)
    cell, corner = np.nonzero(sides[voronoi.neighbours[inner]] == 0)
    return voronoi.cells[inner[cell, None], FACETS[corner]].astype(np.int64)


def random_sides(voronoi, count, share, seed):
    rng = np.random.default_rng(seed)
    sides = (rng.random(len(voronoi.cells)) < share).astype(np.uint8)
    sides[(voronoi.cells >= count).any(axis=1)] = 0
    return sides


def test_the_surface_of_a_sphere_is_its_convex_hull():
    samples = shapes.fibonacci_sphere(700)
    surface = surface_through(samples)
    assert_solid(surface)
    assert surface.left_out == 0
    assert np.array_equal(surface.samples, np.arange(700))
    assert np.array_equal(surface.points, samples)
    assert len(surface.faces) == 2 * 700 - 4
    hull = delaunay(samples)
    cell, corner = np.nonzero(hull.neighbours < 0)
    facets = np.sort(hull.cells[cell[:, None], FACETS[corner]], axis=1)
    assert np.array_equal(
        np.unique(np.sort(surface.faces, axis=1), axis=0), np.unique(facets, axis=0)
    )


def test_a_torus_of_random_samples_has_a_handle_and_every_sample():
    samples = shapes.torus(5000, seed=5)
    surface = surface_through(samples)
    assert_solid(surface, genus=1)
    assert surface.left_out == 0
    assert len(surface.faces) == 2 * 5000
    # inscribed where it is convex, circumscribed where it is a saddle: second order in the spacing
    assert enclosed_volume(surface.points, surface.faces) == pytest.approx(
        2 * np.pi**2 * 0.4**2, rel=0.01
    )


@pytest.mark.parametrize("steps_of_lattice", [4, 9])
def test_a_lattice_box_is_exact(steps_of_lattice):
    """All its samples are cospherical with others; its walls are flat, its edges sharp."""
    surface = surface_through(shapes.box_lattice(steps_of_lattice))
    assert_solid(surface)
    assert surface.left_out == 0
    assert enclosed_volume(surface.points, surface.faces) == pytest.approx(
        steps_of_lattice**3, rel=1e-12
    )


def test_points_are_samples_and_noise_leaves_the_genus_alone():
    rng = np.random.default_rng(3)
    samples = shapes.torus(4000, seed=4) + 0.01 * rng.normal(size=(4000, 3))
    surface = surface_through(samples)
    assert_solid(surface, genus=1)
    assert np.array_equal(surface.points, samples[surface.samples])
    assert surface.left_out == 4000 - len(surface.points)


def test_outliers_are_left_out():
    rng = np.random.default_rng(6)
    ball, far = shapes.fibonacci_sphere(1500), 1.2 + rng.random((12, 3))
    surface = surface_through(np.vstack([ball * (1 + 1e-4 * rng.random((1500, 1))), far]))
    assert_solid(surface)
    assert surface.left_out == 12
    assert surface.samples.max() < 1500


def test_flat_cells_take_the_side_that_bends_the_surface_less():
    """No exchange of two triangles over a flat cell is left that would flatten the surface."""
    voronoi, poles, diagram, inside = steps(shapes.torus(1200, seed=9))
    rough = interpolating_faces(voronoi, poles, diagram, inside)
    again = _native.settle_sides(
        poles.sites, voronoi.cells, voronoi.neighbours, 1200, inner_cells(voronoi, rough), 0
    )
    assert np.array_equal(again, inner_cells(voronoi, rough))
    normals = np.cross(
        *(rough.points[rough.faces[:, k]] - rough.points[rough.faces[:, 0]] for k in (1, 2))
    )
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    places = rough.points[rough.faces].mean(axis=1)
    ring = np.hypot(places[:, 0], places[:, 1])[:, None]
    outward = places - places * [1, 1, 0] / ring
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", normals, outward).min() > 0.5


def inner_cells(voronoi, surface):
    """(m,) 1 for cells that no path free of surface triangles joins to the hull."""
    walls = {tuple(row) for row in np.sort(surface.samples[surface.faces], axis=1).tolist()}
    inside = np.ones(len(voronoi.cells), dtype=np.uint8)
    stack = np.flatnonzero((voronoi.neighbours < 0).any(axis=1)).tolist()
    inside[stack] = 0
    while stack:
        cell = stack.pop()
        for corner, following in enumerate(voronoi.neighbours[cell]):
            facet = tuple(np.sort(np.delete(voronoi.cells[cell], corner)).tolist())
            if following >= 0 and inside[following] and facet not in walls:
                inside[following] = 0
                stack.append(following)
    return inside


@pytest.mark.parametrize("share", [0.03, 0.3, 0.8])
def test_any_sides_become_a_closed_manifold(share):
    samples = shapes.torus(500, seed=2)
    voronoi = delaunay(enclose(samples))
    for seed in range(4):
        sides = random_sides(voronoi, 500, share, seed)
        assert not topology(boundary(voronoi, sides)).vertex_manifold or share < 0.1
        settled = _native.settle_sides(
            voronoi.sites, voronoi.cells, voronoi.neighbours, 500, sides, 0
        )
        shape = topology(boundary(voronoi, settled))
        assert shape.closed
        assert shape.edge_manifold
        assert shape.vertex_manifold
        assert shape.oriented
        assert np.array_equal(sides, random_sides(voronoi, 500, share, seed))


@pytest.mark.parametrize("share", [0.05, 0.5])
def test_settled_sides_do_not_depend_on_the_order_of_the_cells(share):
    rng = np.random.default_rng(8)
    samples = shapes.torus(700, seed=3)
    voronoi = delaunay(enclose(samples))
    sides = inner_cells(voronoi, surface_through(samples)) ^ random_sides(voronoi, 700, share, 1)
    sides[(voronoi.cells >= 700).any(axis=1)] = 0
    order = rng.permutation(len(sides))
    place = np.append(np.argsort(order), -1).astype(np.int32)
    settled = _native.settle_sides(voronoi.sites, voronoi.cells, voronoi.neighbours, 700, sides, 20)
    again = _native.settle_sides(
        voronoi.sites, voronoi.cells[order], place[voronoi.neighbours[order]], 700, sides[order], 20
    )
    assert np.count_nonzero(settled != sides) > 100
    assert np.array_equal(settled[order], again)


@pytest.mark.parametrize("seed", range(3))
def test_any_labels_of_poles_give_a_closed_manifold(seed):
    voronoi, poles, diagram, inside = steps(shapes.torus(800, seed=7))
    wrong = np.random.default_rng(seed).random(len(inside)) < 0.3
    shape = topology(interpolating_faces(voronoi, poles, diagram, inside ^ wrong).faces)
    assert shape.closed
    assert shape.vertex_manifold
    assert shape.oriented


def test_nothing_inside_is_an_empty_surface():
    voronoi, poles, diagram, inside = steps(shapes.fibonacci_sphere(100))
    surface = interpolating_faces(voronoi, poles, diagram, np.zeros_like(inside))
    assert surface.points.shape == (0, 3)
    assert surface.faces.shape == (0, 3)
    assert surface.left_out == 100


def test_small_islands_and_bubbles_go():
    samples = shapes.fibonacci_sphere(400)
    voronoi = delaunay(enclose(np.vstack([samples, 0.3 * shapes.fibonacci_sphere(30)])))
    radius = np.linalg.norm(voronoi.sites[voronoi.cells], axis=2)
    bubble = (radius < 0.5).all(axis=1)
    body = (radius < 1.5).all(axis=1)
    for sides, whole in ((body & ~bubble, body), (bubble, bubble)):
        kept = _native.settle_sides(
            voronoi.sites, voronoi.cells, voronoi.neighbours, 430, sides.astype(np.uint8), 100
        )
        # the bubble is filled; an island that is all there is stays
        assert topology(boundary(voronoi, kept)).components == 1
        assert np.array_equal(kept.astype(bool), whole)


@pytest.mark.parametrize("motion", shapes.MOTIONS, ids=lambda motion: motion.name)
def test_the_surface_moves_with_the_samples(motion):
    samples = shapes.statue(1500, seed=1)
    at_rest, moved = surface_through(samples), surface_through(motion(samples))
    assert_solid(at_rest)
    assert_solid(moved)
    triangles = {tuple(row) for row in np.sort(at_rest.samples[at_rest.faces], axis=1).tolist()}
    again = {tuple(row) for row in np.sort(moved.samples[moved.faces], axis=1).tolist()}
    assert triangles == again


def test_every_triangle_is_near_the_surface_that_was_sampled():
    samples = shapes.torus(6000, seed=12)
    surface = surface_through(samples)
    places = surface.points[surface.faces].mean(axis=1)
    off = np.abs(np.hypot(np.hypot(places[:, 0], places[:, 1]) - 1.0, places[:, 2]) - 0.4)
    spacing = cKDTree(samples).query(samples, k=5)[0][:, 1:].mean(axis=1).max()
    assert off.max() < spacing**2 / 0.4


def test_inner_cells_at_the_corners_of_the_enclosure_are_refused():
    voronoi = delaunay(enclose(shapes.fibonacci_sphere(50)))
    sides = np.ones(len(voronoi.cells), dtype=np.uint8)
    with pytest.raises(ValueError, match="no sample"):
        _native.settle_sides(voronoi.sites, voronoi.cells, voronoi.neighbours, 50, sides, 0)


def test_poles_of_another_triangulation_are_refused():
    _, poles, diagram, inside = steps(shapes.fibonacci_sphere(120))
    other = delaunay(enclose(shapes.statue(120, seed=3)))
    with pytest.raises(ValueError, match="without its cell"):
        interpolating_faces(other, poles, diagram, inside)


@pytest.mark.parametrize("noise", [0.02, 0.04])
def test_wrong_sides_in_noise_leave_the_body(noise):
    """A tenth of the cells on the wrong side, pinched everywhere, is mended and not eaten up."""
    rng = np.random.default_rng(21)
    samples = shapes.torus(6000, seed=20) + noise * rng.normal(size=(6000, 3))
    voronoi = delaunay(enclose(samples))
    body = inner_cells(voronoi, surface_through(samples))
    sides = body ^ random_sides(voronoi, 6000, 0.1, seed=2)
    settled = _native.settle_sides(
        voronoi.sites, voronoi.cells, voronoi.neighbours, 6000, sides, 60
    )
    faces = boundary(voronoi, settled)
    assert topology(faces).vertex_manifold
    assert enclosed_volume(voronoi.sites, faces) == pytest.approx(2 * np.pi**2 * 0.4**2, rel=0.1)
