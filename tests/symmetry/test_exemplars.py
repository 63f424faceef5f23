import numpy as np
import pytest
from symmetry.bodies import no_planes

from meshlab_symrecon.geometry.planes import plane_angles
from meshlab_symrecon.symmetry.candidates import vote
from meshlab_symrecon.symmetry.exemplars import MOST_EXEMPLARS, choose_exemplars
from meshlab_symrecon.symmetry.preparation import prepare


@pytest.fixture(scope="module")
def voted(statue):
    cloud = prepare(statue, None, 1_000)
    return cloud, vote(cloud, 800, 8_000, np.random.default_rng(0)).planes


def test_exemplars_are_candidates_and_one_is_near_the_true_plane(voted):
    cloud, candidates = voted
    found, converged = choose_exemplars(cloud, candidates)
    rows = {row.tobytes() for row in candidates}
    assert all(row.tobytes() in rows for row in found)
    assert len({row.tobytes() for row in found}) == len(found) <= MOST_EXEMPLARS
    assert len(found) < len(candidates) / 10
    assert converged
    true = cloud.from_input(np.array([[1.0, 0.0, 0.0, 0.0]]))[0]
    near = plane_angles(found[:5], true) < np.radians(6.0)
    assert near.any()


def test_the_order_of_candidates_does_not_matter(voted):
    cloud, candidates = voted
    found, _ = choose_exemplars(cloud, candidates)
    shuffled, _ = choose_exemplars(cloud, np.random.default_rng(1).permutation(candidates))
    assert {row.tobytes() for row in found} == {row.tobytes() for row in shuffled}


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_a_few_candidates_that_differ_are_exemplars_all(voted, count):
    cloud, _ = voted
    found, converged = choose_exemplars(cloud, np.eye(4)[:3][:count])
    assert converged
    assert found.shape == (count, 4)
    assert {tuple(row) for row in found} == {tuple(row) for row in np.eye(4)[:count]}


def test_candidates_that_repeat_each_other_have_one_exemplar(voted):
    cloud, _ = voted
    repeated = np.repeat(np.eye(4)[:1], 40, axis=0)
    assert np.array_equal(choose_exemplars(cloud, repeated)[0], np.eye(4)[:1])
    assert choose_exemplars(cloud, no_planes())[0].shape == (0, 4)
