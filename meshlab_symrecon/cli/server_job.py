"""What a command line of ``meshlabserver`` asks for, as plain data."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

__all__ = ["CURRENT", "FLAGS", "LAST", "Job", "Load", "Output", "ProjectOutput"]

CURRENT, LAST = "current", "last"
FLAGS = {
    "vc": "vertex colours",
    "vf": "vertex flags",
    "vq": "vertex quality",
    "vn": "vertex normals",
    "vt": "vertex texture coordinates",
    "vr": "vertex radii",
    "fc": "face colours",
    "ff": "face flags",
    "fq": "face quality",
    "fn": "face normals",
    "wc": "wedge colours",
    "wn": "wedge normals",
    "wt": "wedge texture coordinates",
    "mp": "polygons",
    "sa": "written as text",
}


@dataclass(frozen=True, slots=True)
class Load:
    """A file to load, and the option it stands behind."""

    path: Path
    project: bool = False


@dataclass(frozen=True, slots=True)
class Output:
    """A layer to save.

    Attributes
    ----------
    path : Path
    layer : int or str
        Position of the layer, ``CURRENT`` or ``LAST``.
    mask : frozenset of str
        Flags, keys of ``FLAGS``; none for coordinates and faces alone.
    """

    path: Path
    layer: int | str = CURRENT
    mask: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class ProjectOutput:
    """A project to save; ``overwrite`` puts its layers where they came from."""

    path: Path
    overwrite: bool = False


@dataclass(frozen=True, slots=True)
class Job:
    """What a command line asks for.

    Loads are in the order of the command line; so are scripts, and outputs of either kind.
    ``notes`` says what was read otherwise than written.
    """

    loads: tuple[Load, ...] = ()
    scripts: tuple[Path, ...] = ()
    outputs: tuple[Output, ...] = ()
    projects: tuple[ProjectOutput, ...] = ()
    log: Path | None = None
    dump: Path | None = None
    report: Path | None = None
    keep_all: bool = False
    bake: bool = False
    strict: bool = False
    lenient: bool = False
    dry_run: bool = False
    list_filters: bool = False
    help: bool = False
    version: bool = False
    notes: tuple[str, ...] = ()
