"""Calls of the kernel that nobody in his right mind would make, numbered by a seed.

A call may give a result or refuse; `outcome` says what happened, and raises nothing but what is a
defect.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
import shapes

from meshlab_symrecon import _native
from meshlab_symrecon.clustering.affinity_propagation import AffinityPropagation
from meshlab_symrecon.clustering.simplification import simplify
from meshlab_symrecon.errors import SymReconError
from meshlab_symrecon.geometry.triangulation import circumcentres, delaunay, regular_triangulation
from meshlab_symrecon.powercrust import Recipe, reconstruct
from meshlab_symrecon.symmetry import (
    detect_reflection_planes,
    mirror_complete,
    mirror_deviation,
    refine_reflection_planes,
)

MOST_POINTS = 200
CLASSES = ("MinimumCut", "NearestField")
# What the bindings may raise on arrays that do not fit; the package's own border, its own family.
REFUSALS = (ValueError, TypeError)


class Stop(Exception):
    """Raised by a progress callback that has had enough."""


@dataclass(frozen=True)
class Call:
    """A function, what it is called with, and what it may raise."""

    name: str
    run: Callable[[], object]
    refusals: tuple[type[BaseException], ...]


@dataclass
class Recorded:
    """Arguments that the package itself gives to the bindings."""

    calls: dict[str, list[tuple]] = field(default_factory=dict)

    def keep(self, name, arguments):
        known = self.calls.setdefault(name, [])
        if len(known) < 3:
            known.append(arguments)


def outcome(call):
    """Make the call; return ``result`` or ``refused: ...``."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            call.run()
        except Stop:
            return "stopped"
        except call.refusals as error:
            return f"refused: {type(error).__name__}: {error}"
    return "result"


# Clouds


def _sphere(rng, count):
    directions = rng.normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


CLOUDS = {
    "random": lambda rng, n: rng.random((n, 3)),
    "sphere": _sphere,
    "lattice": lambda rng, n: rng.integers(0, 5, (n, 3)).astype(float),
    "plane": lambda rng, n: rng.random((n, 3)) * [1.0, 1.0, 0.0],
    "tilted plane": lambda rng, n: rng.random((n, 2)) @ rng.normal(size=(2, 3)),
    "line": lambda rng, n: rng.random((n, 1)) * [1.0, 2.0, 3.0],
    "one place": lambda rng, n: np.tile(rng.random(3), (n, 1)),
    "two places": lambda rng, n: rng.random((2, 3))[rng.integers(0, 2, n)],
    "twins": lambda rng, n: np.repeat(rng.random(((n + 1) // 2, 3)), 2, axis=0),
    "near twins": lambda rng, n: (
        np.repeat(shapes.fibonacci_sphere((n + 3) // 2), 2, axis=0)
        + 1e-9 * rng.random((2 * ((n + 3) // 2), 3))
    ),
    "far": lambda rng, n: rng.random((n, 3)) + 1e9,
    "far cluster": lambda rng, n: np.vstack([rng.random((n, 3)), rng.random((3, 3)) + 1e9]),
    "mixed scales": lambda rng, n: rng.normal(size=(n, 3)) * 10.0 ** rng.integers(-12, 13, (n, 1)),
    "all scales": lambda rng, n: rng.normal(size=(n, 3)) * 10.0 ** rng.integers(-300, 301, (n, 3)),
    "needle": lambda rng, n: rng.random((n, 3)) * [1.0, 1e-9, 1e-15],
    "thin": lambda rng, n: rng.random((n, 3)) * [1.0, 1.0, 1e-13],
    "statue": lambda rng, n: shapes.statue(max(n, 20)),
    "torus": lambda rng, n: shapes.torus(max(n, 20), seed=int(rng.integers(9))),
    "few values": lambda rng, n: rng.choice(
        [0.0, -0.0, 1.0, -1.0, 5e-324, 1e-308, 1e308, -1e308, 1e150, 1e-150, 1e9, 2.0**53], (n, 3)
    ),
}
SIZES = (1e150, 1e-150, 1e300, 1e-300, 1e-308, 1e9, 1e-9)
POISONS = (np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, -0.0, 1e200)


def cloud(rng):
    """Return points, mostly of a hostile kind."""
    name = str(rng.choice(list(CLOUDS)))
    count = int(rng.choice([0, 1, 2, 3, 4, 5, 6, 9, 20, 60, MOST_POINTS]))
    points = CLOUDS[name](rng, count)
    if rng.random() < 0.15:
        points = points * float(rng.choice(SIZES))
    if rng.random() < 0.1 and points.size:
        points = points.copy()
        points[rng.integers(len(points)), rng.integers(3)] = rng.choice(POISONS)
    return _dressed(rng, points)


def _read_only(array):
    array = array.copy()
    array.setflags(write=False)
    return array


DRESSES = (
    np.asfortranarray,
    lambda array: np.repeat(array, 2, axis=0)[::2],
    lambda array: array[::-1],
    _read_only,
    lambda array: array.astype(np.float32),
    lambda array: array.astype(np.float16),
    lambda array: array.astype(np.longdouble),
    lambda array: array.astype(object),
    lambda array: array.tolist(),
)


def _dressed(rng, array):
    """Return the same numbers in another layout, or not quite."""
    return _some(rng, *DRESSES)(array) if rng.random() < 0.35 else array


def _progress(rng, *arrays):
    """Return a callback that looks on, gives up, or changes what it was not given."""
    kind, calls = rng.random(), 0
    limit = int(rng.integers(1, 6))
    if kind < 0.5:
        return None

    def callback(*_):
        nonlocal calls
        calls += 1
        if kind < 0.7 and calls >= limit:
            raise Stop
        if kind > 0.9:
            for array in arrays:
                if isinstance(array, np.ndarray) and array.flags.writeable:
                    array[...] = 0

    return callback


# The public functions


def _some(rng, *values):
    return values[rng.integers(len(values))]


def _planes(rng):
    planes = rng.normal(size=(int(rng.integers(0, 4)), 4)) * float(
        _some(rng, 1.0, 1e150, 1e-150, 1e-308, 0.0)
    )
    return _some(rng, planes, np.array([1.0, 0.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0, -1e300]))


def _beside(rng, points):
    """Return normals or numbers beside the points, of the right size or not."""
    count = len(points)
    normals = rng.normal(size=(count, 3)) * float(_some(rng, 1.0, 1.0, 0.0, 1e200, 1e-200))
    return _some(
        rng, None, None, normals, normals[:-1], np.zeros((count, 3)), np.full((count, 3), np.nan)
    )


def public_call(rng):
    """Return a call of what users call."""
    points = cloud(rng)
    progress = _progress(rng, points)
    beside = _beside(rng, points)
    recipe = Recipe(
        surface=_some(rng, "power crust", "interpolating"),
        labelling=_some(rng, "min cut", "propagation"),
        smallest_ball=_some(rng, None, 0.0, 1.0, 1e9),
        widest_cap=_some(rng, 0.0, 0.0, 3.0, 1e300),
        axis_noise=_some(rng, 0.0, 0.5, 1e300),
        axis_redundancy=_some(rng, 0.0, 0.5, 1e300),
        keep_outliers=_some(rng, False, True),
        with_outer_axis=_some(rng, False, True),
    )
    faces = rng.integers(-1, len(points) + 1, (int(rng.integers(0, 30)), 3))
    if rng.random() < 0.7 and len(points):
        faces = np.clip(faces, 0, len(points) - 1)
    count = _some(rng, None, 1, 5, 40, 10**9, 0, -1)
    weights = rng.normal(size=len(points)) * float(_some(rng, 1.0, 0.0, 1e300, 1e-300))
    calls = {
        "reconstruct": lambda: reconstruct(points, recipe, progress=progress),
        "delaunay": lambda: circumcentres(delaunay(points, progress=progress)),
        "regular_triangulation": lambda: regular_triangulation(points, weights, progress=progress),
        "detect_reflection_planes": lambda: detect_reflection_planes(
            points, beside, progress=progress
        ),
        "refine_reflection_planes": lambda: refine_reflection_planes(
            points, _planes(rng), beside, progress=progress
        ),
        "mirror_complete": lambda: mirror_complete(points, _planes(rng), beside, progress=progress),
        "mirror_deviation": lambda: mirror_deviation(
            points, _some(rng, *_planes(rng), [1.0, 0.0, 0.0, 0.0]), _some(rng, None, faces), beside
        ),
        "simplify": lambda: simplify(
            points,
            count=count,
            preference=_some(rng, None, None, -1.0, 1.0, -1e300),
            progress=progress,
        ),
        "AffinityPropagation": lambda: AffinityPropagation(
            preference=_some(rng, None, -1.0, -1e300),
            n_neighbors=_some(rng, None, 2, 32),
            max_iter=50,
        ).fit(points),
    }
    name = str(rng.choice(list(calls)))
    # scikit-learn checks the estimator's data itself, with ValueError, as its interface asks
    refusals = (
        (ValueError, TypeError, UserWarning) if name == "AffinityPropagation" else (SymReconError,)
    )
    return Call(name, calls[name], refusals)


# The bindings


@contextmanager
def _recording(recorded):
    """Let the package run, and keep what it gives to the bindings."""
    kept = {name: getattr(_native, name) for name in dir(_native) if not name.startswith("_")}

    def spy(name):
        def called(*args, **kwargs):
            recorded.keep(name, (args, kwargs))
            return kept[name](*args, **kwargs)

        return called

    try:
        for name in kept:
            if not inspect.isclass(kept[name]) or name in CLASSES:
                setattr(_native, name, spy(name))
        yield
    finally:
        for name, function in kept.items():
            setattr(_native, name, function)


def recorded_calls():
    """Return calls of every binding that the package itself makes, on a small body."""
    recorded = Recorded()
    body = shapes.statue(250)
    torus = shapes.torus(150, seed=1)
    with _recording(recorded):
        reconstruct(body, Recipe(with_outer_axis=True, axis_redundancy=0.5, widest_cap=3.0))
        reconstruct(
            torus, Recipe(surface="interpolating", labelling="propagation", smallest_ball=1.5)
        )
        rng = np.random.default_rng(0)
        noisy = np.vstack([body + rng.normal(0.0, 0.02, body.shape), rng.random((5, 3)) * 4])
        reconstruct(noisy, Recipe())
        detect_reflection_planes(body)
        mirror_complete(body[body[:, 0] > -0.1], [1.0, 0.0, 0.0, 0.0])
        mirror_deviation(body, [1.0, 0.0, 0.0, 0.0], delaunay(body).cells[:40, :3])
        simplify(body, count=40)
        AffinityPropagation(n_neighbors=None).fit(body[:50])
    four, five = body[:4].copy(), body[:5].copy()
    recorded.keep("orientation", ((four,), {}))
    ball = delaunay(body)
    recorded.keep("orthocentres", ((body, np.zeros(len(body)), ball.cells), {}))
    reach, order = np.full(len(body), 0.1), np.arange(len(body), dtype=np.int32)
    recorded.keep("nearest_kept", ((body, reach, order, 0.1), {}))
    recorded.keep("power_test", ((five, np.arange(5.0)), {}))
    recorded.keep("perturbed_power_test", ((five, np.arange(5.0)), {}))
    recorded.keep("fine_power_determinant", ((five, np.arange(5.0), True), {}))
    for kept in recorded.calls.values():
        for place, (args, kwargs) in enumerate(kept):
            kept[place] = (
                tuple(_without_callback(a) for a in args),
                {k: _without_callback(a) for k, a in kwargs.items()},
            )
    return recorded.calls


def _without_callback(argument):
    return None if callable(argument) and not isinstance(argument, np.ndarray) else argument


MISFITS = (
    lambda rng, array: array[:-1],
    lambda rng, array: array[:0],
    lambda rng, array: np.concatenate([array, array[-1:]]),
    lambda rng, array: array.astype(rng.choice(["f8", "i8", "i1", "f4", "u4", "c16", "O"])),
    lambda rng, array: _some(rng, array.ravel(), array[..., None], np.asfortranarray(array)),
    lambda rng, array: array.T,
    lambda rng, array: rng.permuted(array, axis=0),
    lambda rng, array: rng.permutation(array),
    lambda rng, array: _some(rng, None, 0, "points", [], [[1, 2], [3]], np.array(1.0)),
)


def _spoilt_array(rng, array):
    """Return an array with something wrong with it, or another one in its place."""
    if array.ndim == 0 or array.dtype.kind not in "iuf":
        return array
    if rng.random() < 0.6:
        return _some(rng, *MISFITS)(rng, array)
    return _with_wrong_numbers(rng, array.copy()) if array.size else array


def _with_wrong_numbers(rng, array):
    flat = array.reshape(-1)
    places = rng.integers(0, flat.size, int(rng.integers(1, 4)))
    if array.dtype.kind == "f":
        flat[places] = rng.choice([*POISONS, -1.0, 0.0, 1.0]).astype(array.dtype)
        if rng.random() < 0.3:
            flat[:] = flat[places[0]]
    elif rng.random() < 0.5:
        limits = np.iinfo(array.dtype)
        wrong = [-1, -1, limits.min, limits.max, len(array), len(array) - 1, 0, 1, 2, 255]
        flat[places] = np.clip(rng.choice(wrong), limits.min, limits.max)
    else:
        flat[places] = rng.choice(flat, len(places))  # in range, yet not what belongs there
    return array


def _spoilt(rng, argument):
    if isinstance(argument, np.ndarray):
        return _spoilt_array(rng, argument)
    if isinstance(argument, bool):
        return not argument
    if isinstance(argument, int):
        return int(_some(rng, -1, 0, 1, 7, 10**6, 2**31 - 1, -(2**31), 2**40))
    if isinstance(argument, float):
        return float(_some(rng, np.nan, np.inf, -np.inf, -1.0, 0.0, 1e308, 5e-324, 1e-9, 1e9))
    return argument


def _made_small(name, argument, value):
    """Keep iterations within what can be waited for, and tables within memory."""
    if not isinstance(value, int) or isinstance(value, bool):
        return value
    if name.startswith("propagate_") and argument > 1:
        return min(value, 60)
    return min(value, 10**6) if name in ("surface_topology", "pole_graph") else value


def native_call(rng, recorded):
    """Return a call of a binding with one to three of its arguments spoilt."""
    name = str(rng.choice(sorted(recorded)))
    args, kwargs = recorded[name][rng.integers(len(recorded[name]))]
    args, kwargs = list(args), dict(kwargs)
    for _ in range(int(rng.integers(1, 4))):
        chosen = int(rng.integers(len(args) + len(kwargs)))
        if chosen < len(args):
            args[chosen] = _spoilt(rng, args[chosen])
        else:
            key = list(kwargs)[chosen - len(args)]
            kwargs[key] = _spoilt(rng, kwargs[key])
    args = [_made_small(name, place, value) for place, value in enumerate(args)]
    function = getattr(_native, name)
    if "progress: " in (function.__doc__ or ""):
        kwargs["progress"] = _progress(rng)
        args = args[: len(args) - (args[-1:] == [None])]
    if name == "MinimumCut":
        return Call(name, lambda: _cut_twice(rng, args, kwargs), REFUSALS)
    if name == "NearestField":
        return Call(name, lambda: _looked_up(rng, args, kwargs), REFUSALS)
    return Call(name, lambda: function(*args, **kwargs), REFUSALS)


def _cut_twice(rng, args, kwargs):
    cut = _native.MinimumCut(*args, **kwargs)
    nodes = len(args[0]) - 1
    for _ in range(2):
        most = int(_some(rng, 9, 2**20, 2**31 - 1))
        ties = rng.integers(-most, most, nodes, dtype=np.int32)
        cut.inner_side(_spoilt(rng, ties) if rng.random() < 0.5 else ties, _progress(rng))


def _looked_up(rng, args, kwargs):
    nearest = _native.NearestField(*args, **kwargs)
    places = rng.normal(size=(20, 3))
    places[:8, 0] = POISONS
    for found in (nearest.lookup(places), nearest.closest(places), nearest.closest(places, 0.1)):
        assert ((found >= 0) & (found < len(args[0]))).all()


def call_of(seed, recorded):
    """Return the call of a number."""
    rng = np.random.default_rng(seed)
    with np.errstate(all="ignore"):
        return native_call(rng, recorded) if seed % 2 else public_call(rng)
