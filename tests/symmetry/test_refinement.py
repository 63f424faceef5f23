import dataclasses

import numpy as np
import pytest
from symmetry import numpy_loops
from symmetry.bodies import as_prepared, symmetric_cloud

from meshlab_symrecon import _native
from meshlab_symrecon.geometry.neighbours import nearest_field
from meshlab_symrecon.symmetry.preparation import prepare
from meshlab_symrecon.symmetry.refinement import Schedule, _rules, refine_planes


@pytest.mark.parametrize("seed", range(4))
def test_a_perturbed_plane_of_an_exactly_symmetric_cloud_is_recovered(seed):
    points, normals, plane = symmetric_cloud(seed)
    rng = np.random.default_rng(seed)
    starts = np.repeat(plane[np.newaxis], 5, axis=0)
    starts[:, :3] += rng.normal(0, 0.02, size=(5, 3))
    starts[:, 3] += rng.normal(0, 0.005, size=5)
    starts /= np.linalg.norm(starts[:, :3], axis=1, keepdims=True)
    cloud = as_prepared(points, normals)
    schedule = Schedule(40, 0.04, 0.003)
    found = refine_planes(starts, np.arange(len(points)), cloud, schedule, exact=True)
    assert np.abs(starts - plane).max() > 1e-3
    assert np.abs(found - plane).max() < 1e-6


@pytest.mark.parametrize("exact", [False, True])
def test_a_plane_without_partners_stays(exact):
    cloud = as_prepared(*symmetric_cloud()[:2])
    far = np.array([[1.0, 0.0, 0.0, -50.0], [0.6, 0.0, 0.8, 7.0]])
    found = refine_planes(far, np.arange(3_000), cloud, Schedule(5, 0.04, 0.01), exact=exact)
    assert np.array_equal(found, far)


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("steps", [1, 6, 30])
def test_all_steps_are_as_in_the_sums_of_numpy(statue, some_planes, exact, steps):
    cloud = prepare(statue, None, 600)
    queries = cloud.samples[:500]
    last = np.linspace(0.006, 0.02, len(some_planes))
    schedule = Schedule(steps, 0.04, last)
    found = refine_planes(some_planes, queries, cloud, schedule, exact=exact)
    expected = numpy_loops.refined(
        some_planes,
        (cloud.points[queries], cloud.normals[queries]),
        (cloud.points, cloud.normals),
        numpy_loops.partners_of(cloud, exact),
        schedule,
    )
    assert (np.abs(expected - some_planes).max(axis=1) > 1e-3).mean() > 0.5  # most planes move
    assert np.abs(found - expected).max() < 1e-9


@pytest.mark.parametrize("cell", [0.01, 0.06])
def test_partners_are_exact_however_coarse_and_narrow_the_table(statue, some_planes, cell):
    cloud = prepare(statue, None, 200)
    coarse = dataclasses.replace(cloud, field=nearest_field(cloud.points, cell, 0.0, 10**6))
    for tolerance in (0.01, 0.3):
        schedule = Schedule(2, tolerance, tolerance)
        wanted = numpy_loops.refined(
            some_planes,
            (cloud.points[cloud.samples], cloud.normals[cloud.samples]),
            (cloud.points, cloud.normals),
            numpy_loops.partners_of(cloud, exact=True),
            schedule,
        )
        found = refine_planes(some_planes, cloud.samples, coarse, schedule, exact=True)
        assert np.abs(found - wanted).max() < 1e-9


def test_each_plane_is_refined_as_if_it_were_alone(statue, some_planes):
    cloud = prepare(statue, None, 400)
    schedule = Schedule(9, 0.04, 0.01)
    together = refine_planes(some_planes, cloud.samples, cloud, schedule, exact=True)
    for start, plane in zip(some_planes[::7], together[::7], strict=True):
        alone = refine_planes(start[np.newaxis], cloud.samples, cloud, schedule, exact=True)
        assert np.array_equal(alone[0], plane)


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"normals": np.zeros((3, 3))}, ValueError),
        ({"tolerances": np.full(3, 0.1)}, ValueError),
        ({"queries": np.array([10**6], dtype=np.int32)}, ValueError),
    ],
)
def test_arrays_that_do_not_fit_together_are_refused(statue, change, error):
    cloud = prepare(statue, None, 300)
    arguments = {
        "planes": np.eye(4)[:2],
        "queries": cloud.samples.astype(np.int32),
        "tolerances": np.full(4, 0.1),
        "field": cloud.field,
        "normals": cloud.normals,
        "exact": False,
        "rules": _rules(),
    }
    assert _native.refine_planes(**arguments).shape == (2, 4)
    with pytest.raises(error):
        _native.refine_planes(**(arguments | change))


def test_tolerances_shrink_geometrically_and_then_stay():
    schedule = Schedule(10, 0.04, 0.01)
    values = [float(schedule.tolerances(step)) for step in range(10)]
    assert values[0] == 0.04
    assert values[3] == pytest.approx(0.02)
    assert values[6:] == pytest.approx([0.01] * 4)
