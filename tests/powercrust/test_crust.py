"""The crust: closed and manifold whatever the labels, lean, and faithful to the power diagram."""

import itertools
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import shapes
from scipy.spatial import cKDTree

from meshlab_symrecon import _native
from meshlab_symrecon.geometry.surfaces import (
    enclosed_volume,
    face_normals,
    surface_area,
    topology,
)
from meshlab_symrecon.geometry.triangulation import FACETS, delaunay, regular_triangulation
from meshlab_symrecon.powercrust.crust import FLAT, REACH, WELD, Crust, crust_faces
from meshlab_symrecon.powercrust.labelling import label_poles
from meshlab_symrecon.powercrust.poles import enclose, find_poles

TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.int32)
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def two_tori(count):
    """Samples of a surface of genus two: two tori that overlap, less what lies inside either."""
    one = shapes.torus(count, seed=2)
    moved = one * [1, 1, -1] + [1.9, 0, 0]
    depth = [
        np.hypot(np.hypot(*(p[:, :2] - [c, 0]).T) - 1, p[:, 2]) for p, c in ((one, 1.9), (moved, 0))
    ]
    return np.concatenate([one[depth[0] > 0.4], moved[depth[1] > 0.4]])


CLOUDS = {
    "torus": lambda: shapes.torus(1500, seed=11),
    "sphere": lambda: shapes.fibonacci_sphere(400),
    "two tori": lambda: two_tori(3000),
    "lattice": lambda: shapes.box_lattice(6),
    "noise": lambda: np.random.default_rng(3).random((300, 3)),
}


@cache
def diagram_of(name):
    samples = CLOUDS[name]()
    poles = find_poles(delaunay(enclose(samples)), len(samples))
    return poles, regular_triangulation(poles.centres, poles.radii**2)


@cache
def true_labels(name):
    poles, diagram = diagram_of(name)
    return label_poles(poles, diagram).inside


def random_labels(name, seed):
    poles, diagram = diagram_of(name)
    hull = np.zeros(len(poles.centres), dtype=bool)
    cell, corner = np.nonzero(diagram.neighbours < 0)
    for step in (1, 2, 3):
        hull[diagram.cells[cell, (corner + step) % 4]] = True
    return (np.random.default_rng(seed).random(len(hull)) < 0.5) & ~hull


def unmerged(name, inside):
    """Return power vertices, their cells and the fans of all polygons."""
    poles, diagram = diagram_of(name)
    cells, offsets, corners = _native.mixed_edge_polygons(
        diagram.cells, diagram.neighbours, inside.astype(np.uint8)
    )
    vertices, nearest = _native.power_vertices(
        poles.centres,
        poles.radii,
        poles.samples.astype(np.int32),
        poles.sites,
        poles.sample_count,
        diagram.cells,
        cells,
        REACH,
    )
    fans = [
        (corners[start], corners[k], corners[k + 1])
        for start, end in itertools.pairwise(offsets)
        for k in range(start + 1, end - 1)
    ]
    return vertices, nearest, cells, np.array(fans, dtype=np.int64)


def assert_closed_manifold(faces):
    shape = topology(faces)
    assert shape.closed
    assert shape.edge_manifold
    assert shape.vertex_manifold
    assert shape.oriented
    return shape


@pytest.mark.parametrize("name", CLOUDS)
@pytest.mark.parametrize("seed", range(4))
def test_any_labels_give_a_closed_manifold_and_joining_keeps_its_topology(name, seed):
    """The crust is closed by construction, so even random labels must not open it."""
    poles, diagram = diagram_of(name)
    inside = random_labels(name, seed)
    before = assert_closed_manifold(unmerged(name, inside)[3])
    after = assert_closed_manifold(crust_faces(poles, diagram, inside).faces)
    assert (before.genus, before.components) == (after.genus, after.components)


@pytest.mark.parametrize(
    ("name", "genus"), [("torus", 1), ("sphere", 0), ("two tori", 2), ("lattice", 0)]
)
def test_the_crust_of_a_shape_has_its_genus_and_faces_outward(name, genus):
    poles, diagram = diagram_of(name)
    inside = true_labels(name)
    crust = crust_faces(poles, diagram, inside)
    shape = assert_closed_manifold(crust.faces)
    assert (shape.genus, shape.components) == (genus, 1)
    vertices, _, _, fans = unmerged(name, inside)
    assert enclosed_volume(crust.points, crust.faces) == pytest.approx(
        enclosed_volume(vertices, fans), rel=0.01
    )
    assert surface_area(crust.points, crust.faces) == pytest.approx(
        surface_area(vertices, fans), rel=0.01
    )


@pytest.mark.parametrize("name", CLOUDS)
def test_no_two_vertices_coincide_and_no_face_is_without_area(name):
    poles, diagram = diagram_of(name)
    crust = crust_faces(poles, diagram, true_labels(name))
    assert len(np.unique(crust.points, axis=0)) == len(crust.points)
    assert np.linalg.norm(face_normals(crust.points, crust.faces), axis=1).min() > 0.0


@pytest.mark.parametrize("name", ["torus", "two tori", "noise"])
def test_samples_that_all_balls_of_a_vertex_touch_are_vertices_bit_for_bit(name):
    poles, diagram = diagram_of(name)
    inside = true_labels(name)
    crust = crust_faces(poles, diagram, inside)
    mixed = np.ptp(inside[diagram.cells].astype(int), axis=1) > 0
    touched = np.concatenate([poles.samples[corner] for corner in diagram.cells[mixed].T], axis=1)
    values, counts = zip(*(np.unique(row, return_counts=True) for row in touched), strict=True)
    shared = np.unique(np.concatenate(values)[np.concatenate(counts) == 4])
    at_sample = (crust.points == poles.sites[crust.nearest]).all(axis=1)
    assert np.isin(shared, crust.nearest[at_sample]).all()


def test_power_vertices_have_equal_power_to_four_balls():
    poles, diagram = diagram_of("torus")
    vertices, _, cells, _ = unmerged("torus", true_labels("torus"))
    corners = diagram.cells[cells]
    centres, weights = poles.centres[corners], poles.radii[corners] ** 2
    arms = centres[:, 1:] - centres[:, :1]
    rise = (arms**2).sum(axis=2) - weights[:, 1:] + weights[:, :1]
    well_shaped = np.linalg.cond(arms) < 1e6
    solved = centres[well_shaped, 0] + np.linalg.solve(
        2 * arms[well_shaped], rise[well_shaped][..., None]
    ).squeeze(-1)
    assert well_shaped.mean() > 0.9
    np.testing.assert_allclose(vertices[well_shaped], solved, atol=1e-8)


def test_vertices_know_the_sample_nearest_to_them():
    poles, diagram = diagram_of("torus")
    crust = crust_faces(poles, diagram, true_labels("torus"))
    samples = poles.sites[: poles.sample_count]
    nearest = cKDTree(samples).query(crust.points)[1]
    assert (crust.nearest == nearest).mean() > 0.99


def test_the_crust_is_lean_and_stays_within_its_tolerance_of_the_power_diagram():
    poles, diagram = diagram_of("torus")
    inside = true_labels("torus")
    crust = crust_faces(poles, diagram, inside)
    vertices, nearest, _, fans = unmerged("torus", inside)
    assert len(crust.faces) < 0.4 * len(fans)
    # each vertex of the unmerged crust has a face of the lean one near by
    corners = crust.points[crust.faces]
    share = np.random.default_rng(5).dirichlet(np.ones(3), size=(len(corners), 60))
    cover = np.einsum("fsk,fkd->fsd", share, corners).reshape(-1, 3)
    distance = cKDTree(cover).query(vertices)[0]
    assert np.quantile(distance / poles.spacing[nearest], 0.99) < 0.5


def test_the_crust_scales_with_the_samples_to_the_last_bit():
    poles, diagram = diagram_of("torus")
    crust = crust_faces(poles, diagram, true_labels("torus"))
    larger = replace(
        poles,
        sites=8.0 * poles.sites,
        centres=8.0 * poles.centres,
        radii=8.0 * poles.radii,
        spacing=8.0 * poles.spacing,
    )
    other = crust_faces(larger, diagram, true_labels("torus"))
    np.testing.assert_array_equal(other.points, 8.0 * crust.points)
    np.testing.assert_array_equal(other.faces, crust.faces)
    np.testing.assert_array_equal(other.nearest, crust.nearest)


def test_no_inner_pole_gives_no_face():
    poles, diagram = diagram_of("sphere")
    crust = crust_faces(poles, diagram, np.zeros(len(poles.centres), dtype=bool))
    assert isinstance(crust, Crust)
    assert crust.points.shape == crust.faces.shape == (0, 3)
    assert len(crust.nearest) == 0


def test_samples_without_neighbours_do_not_swallow_the_surface():
    poles, diagram = diagram_of("torus")
    lonely = replace(poles, spacing=np.full(poles.sample_count, np.inf))
    crust = crust_faces(lonely, diagram, true_labels("torus"))
    shape = assert_closed_manifold(crust.faces)
    assert shape.genus == 1
    vertices, _, _, fans = unmerged("torus", true_labels("torus"))
    assert enclosed_volume(crust.points, crust.faces) == pytest.approx(
        enclosed_volume(vertices, fans), rel=1e-12
    )


def test_progress_rises_and_may_stop_the_work():
    poles, diagram = diagram_of("torus")
    told = []
    crust_faces(poles, diagram, true_labels("torus"), progress=told.append)
    assert told == sorted(told)
    assert told[0] == 0.0
    assert told[-1] <= 1.0

    def stop(fraction):
        if fraction >= 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        crust_faces(poles, diagram, true_labels("torus"), progress=stop)


def test_an_inner_pole_on_the_hull_is_refused():
    points = np.random.default_rng(1).random((20, 3))
    cells = delaunay(points)
    with pytest.raises(ValueError, match="hull"):
        _native.mixed_edge_polygons(
            cells.cells, cells.neighbours, (np.arange(20) < 10).astype(np.uint8)
        )


def test_cells_that_are_no_neighbours_are_refused():
    _, diagram = diagram_of("sphere")
    elsewhere = np.random.default_rng(0).permutation(len(diagram.cells)).astype(np.int32)
    wrong = np.where(diagram.neighbours < 0, -1, elsewhere[diagram.neighbours])
    with pytest.raises(ValueError, match="do not share a facet"):
        _native.mixed_edge_polygons(
            diagram.cells, wrong.astype(np.int32), true_labels("sphere").astype(np.uint8)
        )


def ball_and_inner_sites():
    cells = delaunay(np.random.default_rng(0).random((12, 3)))
    cell, corner = np.nonzero(cells.neighbours < 0)
    inside = np.ones(12, dtype=np.uint8)
    inside[cells.cells[cell[:, None], FACETS[corner]]] = 0
    assert inside.any()
    return cells, inside


def test_a_polygon_that_ends_before_it_closes_is_refused():
    ball, inside = ball_and_inner_sites()
    messages = set()
    for cell, place in itertools.product(range(len(ball.cells)), range(4)):
        wrong = ball.neighbours.copy()
        wrong[cell, place] = cell  # its own neighbour: there is no way out
        try:
            _native.mixed_edge_polygons(ball.cells, wrong, inside)
        except ValueError as error:
            messages.add(str(error))
    assert messages == {"cells of the triangulation do not close round an edge"}


def test_a_cell_that_has_a_site_twice_is_refused():
    ball, inside = ball_and_inner_sites()
    for cell, place in itertools.product(range(len(ball.cells)), range(4)):
        wrong = ball.cells.copy()
        wrong[cell, place] = wrong[cell, place - 1]
        with pytest.raises(ValueError, match="site twice"):
            _native.mixed_edge_polygons(wrong, ball.neighbours, inside)


def test_polygons_of_no_surface_are_refused():
    triangle = np.arange(3, dtype=np.int32)
    with pytest.raises(ValueError, match="four polygons"):
        _native.join_at_samples(
            CORNERS[:3],
            triangle,
            3 * np.arange(6, dtype=np.int32),
            np.tile(triangle, 5),
            CORNERS,
        )


def contract(points, faces, samples, nearest, spacing, progress=None):
    return _native.contract_edges(
        points,
        faces.astype(np.int32),
        np.asarray(nearest, dtype=np.int32),
        samples,
        spacing,
        WELD,
        FLAT,
        progress,
    )


def test_every_step_of_the_contraction_tells_progress_and_may_be_stopped():
    points, faces = shapes.torus_mesh(24, 36)
    cloud = (points, faces, np.array([[9.0, 9, 9]]), np.zeros(len(points)), np.array([4.0]))
    told = []
    contract(*cloud, told.append)
    assert told == sorted(told)
    assert len(set(told)) >= 5  # paired, joined, thinned out, parted, numbered
    assert 0.0 < told[0] < told[-1] < 1.0
    for last in told:

        def stop(share, last=last):
            if share >= last:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            contract(*cloud, stop)


def test_contraction_keeps_the_topology_of_a_torus_and_of_a_tetrahedron():
    points, faces = shapes.torus_mesh(24, 36)
    far = np.array([[9.0, 9, 9]])
    moved, kept, _ = contract(points, faces, far, np.zeros(len(points)), np.array([4.0]))
    assert len(moved) < len(points) / 2
    assert assert_closed_manifold(kept).genus == 1

    _, left, _ = contract(CORNERS, TETRAHEDRON, far, np.zeros(4), np.array([99.0]))
    assert len(left) == 4


def test_vertices_at_one_sample_that_cannot_be_joined_are_moved_apart():
    """Two corners of a tetrahedron at one sample: joining them would leave no solid."""
    corners = CORNERS[[0, 0, 2, 3]]
    points, left, _ = contract(corners, TETRAHEDRON, CORNERS, [0, 0, 2, 3], np.ones(4))
    assert len(left) == 4
    assert len(np.unique(points, axis=0)) == 4
    assert any((point == CORNERS[0]).all() for point in points)


def test_an_open_surface_is_not_contracted():
    with pytest.raises(ValueError, match="closed"):
        contract(CORNERS, TETRAHEDRON[1:], CORNERS, np.arange(4), np.ones(4))
