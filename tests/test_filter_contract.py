"""The contract of every registered filter; a filter without a row in CASES fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cache

import numpy as np
import pytest
import shapes
from scipy.spatial import cKDTree

from meshlab_symrecon.errors import SymReconError
from meshlab_symrecon.geometry.plane_quads import planes_as_quads, planes_of_pieces
from meshlab_symrecon.geometry.surfaces import enclosed_volume
from meshlab_symrecon.host.mlx import step_of
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.mlx_writing import write_script
from meshlab_symrecon.host.resolution import resolve_script
from meshlab_symrecon.plugin import Filter, Layer, Layers, Outcome
from meshlab_symrecon.plugin.parameters import Parameter
from meshlab_symrecon.plugin.registry import installed_filters

REGISTRY = installed_filters()
FILTERS = tuple(REGISTRY)
NO_FACES = np.zeros((0, 3), dtype=np.int64)
MIRROR = np.array([[1.0, 0.0, 0.0, 0.0]])


def frozen(array: np.ndarray) -> np.ndarray:
    array = array.copy()
    array.setflags(write=False)
    return array


def document(points: np.ndarray, planes: np.ndarray = MIRROR) -> Layers:
    """A document of a planes layer and a scan, the scan current; nothing in it can be written."""
    scan = Layer(frozen(points), frozen(NO_FACES), label="scan", identifier=0)
    if len(points) and np.isfinite(points).all():
        corners, faces = planes_as_quads(planes, points)
    else:
        corners, faces = planes_as_quads(planes, np.eye(3))
    sheets = Layer(frozen(corners), frozen(faces), label="reflection planes", identifier=1)
    return Layers({0: scan.label, 1: sheets.label}, 0, (scan, sheets).__getitem__)


@dataclass(frozen=True)
class Case:
    """An input, and how outcomes of a filter are compared after a motion is taken back."""

    points: np.ndarray
    same: Callable[[Outcome, Outcome, shapes.Motion], None]
    flat: bool = False  # points that fill no space are as good as others
    alone: Mapping[str, object] = field(default_factory=dict)  # values that rule others out


def layer_points(outcome: Outcome) -> np.ndarray:
    return outcome.layers[0].points


def same_planes(rest: Outcome, moved: Outcome, motion: shapes.Motion) -> None:
    expected, found = motion.planes(rest.measures["planes"]), moved.measures["planes"]
    assert expected.shape == found.shape
    sign = np.sign(np.einsum("ij,ij->i", expected[:, :3], found[:, :3]))
    cosine = np.abs(np.einsum("ij,ij->i", expected[:, :3], found[:, :3]))
    assert np.degrees(np.arccos(np.minimum(cosine, 1))).max() < 0.3
    centre = motion(np.zeros((1, 3)))[0]
    offsets = expected @ np.append(centre, 1) - sign * (found @ np.append(centre, 1))
    assert np.abs(offsets).max() < 0.005 * motion.scale
    np.testing.assert_allclose(moved.measures["support"], rest.measures["support"], atol=0.05)
    back = planes_of_pieces(moved.layers[0].points, moved.layers[0].faces)
    np.testing.assert_allclose(back[:, :3], found[:, :3], atol=1e-9)


def same_cloud(rest: Outcome, moved: Outcome, motion: shapes.Motion) -> None:
    assert moved.measures["measured"] == rest.measures["measured"]
    assert moved.measures["mirrored"] == pytest.approx(rest.measures["mirrored"], abs=3)
    gaps = cKDTree(motion.back(layer_points(moved))).query(layer_points(rest))[0]
    assert np.mean(gaps > 1e-6) < 0.01


def same_surface(rest: Outcome, moved: Outcome, motion: shapes.Motion) -> None:
    for name in ("closed", "edge_manifold", "vertex_manifold", "components", "genus"):
        assert moved.measures[name] == rest.measures[name]
    gaps = cKDTree(motion.back(layer_points(moved))).query(layer_points(rest))[0]
    assert np.mean(gaps > 1e-6) < 0.05
    faces = rest.layers[0].faces, moved.layers[0].faces
    assert enclosed_volume(layer_points(moved), faces[1]) / motion.scale**3 == pytest.approx(
        enclosed_volume(layer_points(rest), faces[0]),
        rel=1e-3,  # the cap rests on few balls
    )


def same_deviation(rest: Outcome, moved: Outcome, motion: shapes.Motion) -> None:
    for name in ("median", "percentile_95", "rms", "tolerance"):
        assert moved.measures[name] / motion.scale == pytest.approx(rest.measures[name], rel=1e-6)
    for name in ("within_tolerance", "without_counterpart", "signed"):
        assert moved.measures[name] == pytest.approx(rest.measures[name], abs=1e-12)
    before, after = (np.sort(outcome.scalars[0].quality) for outcome in (rest, moved))
    scale = motion.scale * rest.measures["rms"]
    np.testing.assert_allclose(after / scale, before * motion.scale / scale, atol=1e-6)


def same_points(rest: Outcome, moved: Outcome, motion: shapes.Motion) -> None:
    assert moved.measures["points"] == rest.measures["points"]
    back = motion.back(layer_points(moved))
    gaps = cKDTree(back).query(layer_points(rest))[0]
    assert np.mean(gaps > 1e-6) < 0.02  # equal choices may fall the other way


STATUE = shapes.statue(2500, seed=5)
CASES = {
    "generate_reflection_planes": Case(STATUE, same_planes),
    "generate_mirror_completed_points": Case(STATUE, same_cloud),
    "generate_surface_reconstruction_power_crust": Case(STATUE, same_surface),
    "compute_scalar_by_mirror_symmetry_per_vertex": Case(STATUE, same_deviation),
    "generate_simplified_points": Case(
        STATUE, same_points, flat=True, alone={"preference": -16.125}
    ),
}


def apply(item: Filter, points: np.ndarray, planes: np.ndarray = MIRROR) -> Outcome:
    return item.apply(document(points, planes), {})


@cache
def at_rest(item: Filter) -> Outcome:
    """Return what every motion is compared with; a test of its own sees that it repeats."""
    return apply(item, CASES[item.python_name].points)


def arrays_of(outcome: Outcome) -> list[bytes]:
    found = []
    for made in (*outcome.layers, *outcome.scalars):
        values = [getattr(made, field.name) for field in fields(made)]
        found += [value.tobytes() for value in values if isinstance(value, np.ndarray)]
        found += [value.tobytes() for value in made.attributes.values()]
    told = (value for name, value in outcome.measures.items() if name != "seconds")
    return found + [repr(value).encode() for value in told]


every_filter = pytest.mark.parametrize("item", FILTERS, ids=lambda item: item.python_name)


def test_the_installed_filters_all_load():
    assert REGISTRY.failures == ()
    assert set(CASES) <= {item.python_name for item in FILTERS}


@every_filter
def test_it_runs_leaves_its_input_and_repeats_its_bytes(item):
    points = CASES[item.python_name].points
    layers = document(points)
    kept = arrays_of(Outcome((layers.get(0), layers.get(1))))
    first, second = item.apply(layers, {}), item.apply(layers, {})
    assert first.layers or first.scalars
    assert arrays_of(Outcome((layers.get(0), layers.get(1)))) == kept
    assert arrays_of(first) == arrays_of(second)
    assert {layer.label for layer in first.layers} <= set(item.creates)


@every_filter
@pytest.mark.parametrize("motion", shapes.MOTIONS, ids=lambda motion: motion.name)
def test_it_follows_rotation_translation_and_scale(item, motion):
    case = CASES[item.python_name]
    moved = apply(item, motion(case.points), motion.planes(MIRROR))
    case.same(at_rest(item), moved, motion)


@every_filter
def test_the_order_of_the_points_does_not_matter(item):
    case = CASES[item.python_name]
    shuffled = case.points[np.random.default_rng(0).permutation(len(case.points))]
    still = replace(shapes.MOTIONS[0], turn=np.eye(3))
    case.same(at_rest(item), apply(item, shuffled), still)


BAD_POINTS = {
    "no points": np.zeros((0, 3)),
    "one point": np.zeros((1, 3)),
    "two points": np.eye(3)[:2],
    "three points": np.eye(3),
    "four points in a plane": np.vstack([np.eye(3)[:2], -np.eye(3)[:2]]),
    "one point many times": np.ones((50, 3)),
    "collinear": np.outer(np.arange(50.0), [1.0, 2.0, 3.0]),
    "coplanar": np.column_stack([np.random.default_rng(0).random((50, 2)), np.zeros(50)]),
    "NaN": np.vstack([STATUE[:50], [[np.nan, 0, 0]]]),
    "infinite": np.vstack([STATUE[:50], [[np.inf, 0, 0]]]),
}
NEVER_POINTS = {"no points", "NaN", "infinite"}


@every_filter
@pytest.mark.parametrize("name", BAD_POINTS)
def test_bad_points_give_one_sentence(item, name):
    if CASES[item.python_name].flat and name not in NEVER_POINTS:
        (made,) = apply(item, BAD_POINTS[name]).layers
        assert set(map(tuple, made.points)) <= set(map(tuple, BAD_POINTS[name]))
        assert len(made.points)
        return
    with pytest.raises(SymReconError) as caught:
        apply(item, BAD_POINTS[name])
    message = str(caught.value)
    assert "\n" not in message
    assert "got" in message or "needs" in message


@every_filter
def test_duplicates_do_no_harm(item):
    case = CASES[item.python_name]
    doubled = apply(item, np.vstack([case.points, case.points[::5]]))
    assert doubled.layers or doubled.scalars
    assert all(np.isfinite(layer.points).all() for layer in doubled.layers)
    assert all(np.isfinite(scalars.quality).all() for scalars in doubled.scalars)


@every_filter
def test_every_default_survives_a_script(item):
    for parameter in item.parameters.declared():
        assert parameter.parse(parameter.format(parameter.default)) == parameter.default
        assert parameter.label
        assert parameter.tooltip.endswith(".")
    assert item.bind({}).values() == {p.name: p.default for p in item.parameters.declared()}


@every_filter
def test_an_unknown_parameter_is_named(item):
    with pytest.raises(SymReconError, match="unknown parameter 'nonsense'"):
        item.apply(document(STATUE), {"nonsense": 1})


@every_filter
def test_a_script_of_it_reads_back_equal(item, tmp_path):
    alone = CASES[item.python_name].alone
    others = [p for p in item.parameters.declared() if p.name not in alone]
    for values in ({}, alone, {p.name: other_value(p) for p in others}):
        bound = item.bind(values).values()
        write_script([step_of(item, bound)], tmp_path / "a.mlx")
        script = read_script(tmp_path / "a.mlx")
        (step,) = resolve_script(script)
        assert step.filter.python_name == item.python_name
        assert dict(step.values) == bound
        write_script(script.steps, tmp_path / "b.mlx")
        assert (tmp_path / "a.mlx").read_bytes() == (tmp_path / "b.mlx").read_bytes()


def other_value(parameter: Parameter) -> object:
    """An allowed value that is not the default."""
    if isinstance(parameter.default, bool):
        return not parameter.default
    if isinstance(parameter.default, str):
        others = [word for word in parameter.choices if word != parameter.default]
        return others[0] if others else "a <b> & 'c'"
    if isinstance(parameter.default, int):
        return parameter.default + (1 if parameter.default + 1 <= (parameter.high or 99) else -1)
    return parameter.default + 0.1234567890123456789 * (1 if parameter.default < 0.5 else -1)
