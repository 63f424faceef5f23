"""A folder of a hundred made scans, some of which nobody can reconstruct, and a script for them.

92 are incomplete statues of 1200 to 2500 points in five formats; 5 are corrupt; 2 meet a step that
ends its process; 1 needs more memory than the batch may use.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from damage import Damage, damaged
from shapes import STATUES, made

GOOD, CORRUPT, FATAL, LARGE = 92, 5, 2, 1
FORMATS = ("ply", "ply", "obj", "xyz", "off")  # each as often as it is named
FATAL_COUNT = 1717  # points of a scan that the fragile step cannot bear
LARGE_COUNT = 6_000_000  # points of the scan that is too large for two gigabytes
SCRIPT = """<!DOCTYPE FilterScript>
<FilterScript>
 <filter name="Fragile Step"/>
 <filter name="Remove Duplicate Vertices"/>
 <filter name="Compute normals for point sets"/>
 <filter name="Detect Reflection Planes (AP)"/>
 <filter name="Mirror-Complete Points"/>
 <filter name="Surface Reconstruction: Power Crust"/>
</FilterScript>
"""
FRAGILE = f"""import ctypes

from meshlab_symrecon.plugin import Filter, Outcome, ParameterSet


class Parameters(ParameterSet):
    pass


def run(layers, parameters, progress):
    if len(layers.current.points) == {FATAL_COUNT}:
        ctypes.string_at(0)  # as native code with a bug does
    return Outcome(())


FILTER = Filter(
    menu_name="Fragile Step",
    python_name="apply_fragile_step",
    aliases=(),
    summary="Ends the process on some scans.",
    description="Ends the process on some scans.",
    parameters=Parameters,
    run=run,
    meshlab_class="Sampling",
    category="Creation/Sampling",
)
"""


def make_folder(folder: Path, seed: int) -> Mapping[str, str]:
    """Write the scans; return what each of those that must fail is: corrupt, fatal or large."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    places = rng.permutation(GOOD + CORRUPT + FATAL + LARGE)
    kinds = ["good"] * GOOD + ["corrupt"] * CORRUPT + ["fatal"] * FATAL + ["large"] * LARGE
    named = {}
    damages = iter(DAMAGES)
    for place, kind in sorted(zip(places.tolist(), kinds, strict=True)):
        extension = FORMATS[rng.integers(len(FORMATS))] if kind == "good" else "ply"
        path = folder / f"scan_{place:03}.{extension}"
        count = FATAL_COUNT if kind == "fatal" else int(rng.integers(1200, 2500))
        if kind == "large":
            points = np.random.default_rng(seed).normal(size=(LARGE_COUNT, 3))
        else:
            points = statue(int(rng.integers(2**31)), count)
        write(path, points)
        if kind == "corrupt":
            path.write_bytes(next(damages)(path.read_bytes()))
        if kind != "good":
            named[path.name] = kind
    return named


def statue(seed: int, count: int) -> np.ndarray:
    """Return an incomplete statue of exactly ``count`` points, (count, 3)."""
    rng = np.random.default_rng(seed)
    shape = made(list(STATUES)[rng.integers(len(STATUES))], seed)
    scan = damaged(shape, Damage(count=2 * count + 200), seed)
    return scan.points[:count]  # they come in random order


def write(path: Path, points: np.ndarray) -> None:
    """Write a cloud by hand, so that the folder depends on no writer of ours."""
    rows = "".join(f"{x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in points) if len(points) < 1e5 else ""
    if path.suffix == ".ply":
        header = (
            f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
            "property float x\nproperty float y\nproperty float z\nend_header\n"
        )
        path.write_bytes(header.encode() + points.astype("<f4").tobytes())
    elif path.suffix == ".obj":
        path.write_text("".join(f"v {row}\n" for row in rows.splitlines()))
    elif path.suffix == ".off":
        path.write_text(f"OFF\n{len(points)} 0 0\n{rows}")
    else:
        path.write_text(rows)


DAMAGES: tuple[Callable[[bytes], bytes], ...] = (
    lambda content: content[: len(content) * 2 // 3],  # the copy was broken off
    lambda content: b"",
    lambda content: content.replace(b"element vertex ", b"element vertex 9999"),
    lambda content: b"\0" * len(content),  # a disk that lost its blocks
    lambda content: content.replace(b"property float z", b"property flaot z"),
)


def make_plugin(folder: Path) -> Path:
    """Write a distribution with the fragile filter; its folder is for PYTHONPATH."""
    information = folder / "fragile_step-1.0.dist-info"
    information.mkdir(parents=True)
    (folder / "fragile_step.py").write_text(FRAGILE)
    (information / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: fragile-step\nVersion: 1.0\n"
    )
    (information / "entry_points.txt").write_text(
        "[meshlab_symrecon.filters]\nfragile_step = fragile_step:FILTER\n"
    )
    return folder
