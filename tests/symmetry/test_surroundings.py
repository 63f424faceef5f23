import numpy as np
import pytest
from scipy.spatial import cKDTree
from symmetry.bodies import even_sphere

from meshlab_symrecon.symmetry.surroundings import neighbours, surroundings

DIAGONAL = 2.0 * 3**0.5


@pytest.fixture(scope="module")
def sphere():
    return even_sphere(6_000)


def test_the_surroundings_of_a_lattice():
    steps = np.arange(12.0)
    lattice = np.stack(np.meshgrid(steps, steps, [0.0]), axis=-1).reshape(-1, 3)
    around = surroundings(lattice, None, DIAGONAL)
    inner = ((lattice[:, :2] > 0.0) & (lattice[:, :2] < 11.0)).all(axis=1)
    assert around.usual == 1.0
    assert (around.spacing[inner] == 1.0).all()
    assert (around.spacing[~inner] > 1.0).all()
    np.testing.assert_allclose(np.abs(around.directions), np.tile([0, 0, 1], (144, 1)), atol=1e-12)
    assert not around.outward
    known = neighbours(lattice)
    assert (known.nearest != np.arange(144)[:, np.newaxis]).all()
    distances = np.linalg.norm(lattice[known.nearest] - lattice[:, np.newaxis], axis=2)
    assert (np.diff(distances, axis=1) >= 0.0).all()
    np.testing.assert_allclose(known.width, distances.mean(axis=1))
    np.testing.assert_allclose(known.spacing, distances[:, :4].mean(axis=1))


def test_a_spacing_is_believed_within_a_factor_of_two():
    steps = np.concatenate([np.arange(40.0), 40.0 + 10.0 * np.arange(6), 100 + np.arange(9) / 10])
    points = np.column_stack([steps, np.sin(steps), np.cos(steps)])
    around = surroundings(points, None, DIAGONAL)
    believed = around.believed(np.arange(len(steps), dtype=np.int32))
    assert believed.min() == 0.5 * around.usual
    assert believed.max() == 2.0 * around.usual
    usual = np.abs(np.log2(around.spacing / around.usual)) < 1.0
    assert np.array_equal(believed[usual], around.spacing[usual])


def test_given_normals_are_used_at_unit_length_and_zero_stays_zero(sphere):
    normals = sphere * np.linspace(0.0, 5.0, len(sphere))[:, np.newaxis]
    around = surroundings(sphere, normals, 3.0)
    assert around.outward
    np.testing.assert_allclose(around.directions[1:], sphere[1:], atol=1e-12)
    assert not around.directions[0].any()


def test_a_part_keeps_the_spacing_of_the_whole(sphere):
    around = surroundings(sphere, None, DIAGONAL)
    kept = np.arange(len(sphere)) % 3 > 0
    fewer = surroundings(sphere, None, around.diagonal, kept=kept)
    assert np.array_equal(fewer.points, sphere[kept])
    assert np.array_equal(fewer.spacing, around.spacing[kept])
    assert fewer.usual == around.usual
    places = sphere[~kept]
    assert np.array_equal(fewer.field.closest(places), cKDTree(sphere[kept]).query(places)[1])
