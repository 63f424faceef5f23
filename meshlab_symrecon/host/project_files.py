"""What a project file says: layers with their files and matrices, and rasters; no pymeshlab."""

from __future__ import annotations

import base64
import binascii
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import fromstring

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.atomic import reason

__all__ = ["READABLE_PROJECTS", "Project", "ProjectLayer", "read_project"]

READABLE_PROJECTS = ("mlp", "mlb", "aln")
ROOT, LAYER, MATRIX, RASTER, IMAGE = "MeshLabProject", "MLMesh", "MLMatrix44", "MLRaster", "Plane"
IDENTITY = np.eye(4)
LEAST_LINES = 6  # of a layer in an ALN file: its file, a '#', four rows


@dataclass(frozen=True, slots=True, eq=False)
class ProjectLayer:
    """One layer of a project: its file, its label (empty for the file's own), its matrix.

    A layer that is not ``visible`` is passed over by filters that work on visible layers.
    """

    path: Path
    label: str
    matrix: Any  # (4, 4)
    index: int = -1  # which of the meshes in the file; -1 for all of them
    visible: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Project:
    """A project as it was written.

    Attributes
    ----------
    path : Path
    layers : tuple of ProjectLayer
        Paths are joined to the project's folder.
    rasters : tuple of Element
        Those whose images are there, by their full path; each with its camera.
    missing_images : tuple of Path
        The images of the others.
    """

    path: Path
    layers: tuple[ProjectLayer, ...]
    rasters: tuple[ElementTree.Element, ...] = ()
    missing_images: tuple[Path, ...] = ()


def read_project(path: str | Path) -> Project:
    """Read a MeshLab project (``.mlp``, ``.mlb``) or a list of alignments (``.aln``).

    Raises
    ------
    FileError
        The project is missing, is no project, or defines entities; a matrix is not sixteen finite
        numbers; layers' files are missing, all of which are named. Missing images of rasters are
        no error.
    """
    path = Path(path)
    extension = path.suffix.removeprefix(".").lower()
    if extension not in READABLE_PROJECTS:
        known = ", ".join(READABLE_PROJECTS)
        raise FileError(f"{path} is not known as a project; known extensions are {known}")
    try:
        content = None if path.exists() and not path.is_file() else path.read_bytes()
    except (OSError, ValueError) as error:
        message = f"project {path} cannot be read: {reason(error)}; check its path"
        raise FileError(message) from error
    if content is None:
        raise FileError(f"project {path} is not an ordinary file; give a project file")
    project = _aln(path, content) if extension == "aln" else _mlp(path, content)
    absent = list(dict.fromkeys(str(layer.path) for layer in project.layers if not
                                layer.path.is_file()))  # fmt: skip
    if absent:
        message = f"project {path} names {len(absent)} mesh files that are not there: "
        raise FileError(message + ", ".join(absent))
    return project


def _mlp(path: Path, content: bytes) -> Project:
    try:
        root = fromstring(content)
    except ElementTree.ParseError as error:
        raise _no_project(path, f"it is not XML: {error}") from error
    except DefusedXmlException as error:
        raise _no_project(path, "it defines entities, which a project must not") from error
    except (LookupError, ValueError) as error:
        raise _no_project(path, f"its text is unreadable: {error}") from error
    if root.tag != ROOT:
        raise _no_project(path, f"its outermost element is <{root.tag}> instead of <{ROOT}>")
    layers = tuple(_layer(path, element) for element in root.iter(LAYER))
    rasters, missing = _rasters(path, root)
    return Project(path, layers, rasters, missing)


def _layer(path: Path, element: ElementTree.Element) -> ProjectLayer:
    name = element.get("filename", "").strip()
    if not name:
        label = element.get("label", "")
        raise _no_project(path, f"its layer '{label}' names no file; save that layer first")
    found = element.find(MATRIX)
    text = "" if found is None or found.text is None else found.text
    matrix = _matrix(path, name, text) if found is not None else IDENTITY
    try:
        index = int(element.get("idInFile", "-1"))
    except ValueError:
        index = -1
    label = element.get("label", "")
    return ProjectLayer(_joined(path, name), label, matrix, index, _visible(element))


def _visible(element: ElementTree.Element) -> bool:
    """Say whether a layer is shown: to MeshLab, only a written 1 says so, or nothing written."""
    return element.get("visible", "1").strip() == "1"


def _joined(project: Path, name: str) -> Path:
    """Return a file named in a project; those written on Windows have backslashes."""
    found = project.parent / name
    if "\\" in name and not found.is_file():
        return project.parent / name.replace("\\", "/")
    return found


def _matrix(path: Path, name: str, text: str) -> Any:
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        numbers = _packed(text)
    if len(numbers) != IDENTITY.size or not np.isfinite(numbers).all():
        got = " ".join(text.split())
        raise _no_project(
            path, f"the matrix of '{name}' must be 16 finite numbers; got '{got:.100}'"
        )
    return np.array(numbers).reshape(IDENTITY.shape)


def _packed(text: str) -> list[float]:
    """Return the numbers of a matrix of an MLB file, which is the bytes of doubles in base 64."""
    try:
        content = base64.b64decode(text.strip(), validate=True)
        return list(struct.unpack("<16d", content))
    except (binascii.Error, struct.error, ValueError):
        return []


def _rasters(
    path: Path, root: ElementTree.Element
) -> tuple[tuple[ElementTree.Element, ...], tuple[Path, ...]]:
    """Return the rasters with images that are there, by full path; and the images that are not."""
    kept, missing = [], []
    for raster in root.iter(RASTER):
        absent = []
        for image in raster.iter(IMAGE):
            file = _joined(path, image.get("fileName", "")).resolve()
            image.set("fileName", str(file))
            if not file.is_file():
                absent.append(file)
        if not absent:
            kept.append(raster)
        missing += absent
    return tuple(kept), tuple(missing)


def _aln(path: Path, content: bytes) -> Project:
    lines = [line.strip() for line in content.decode("utf-8", "surrogateescape").splitlines()]
    lines = [line for line in lines if line]
    try:
        count = int(lines[0])
    except (IndexError, ValueError) as error:
        raise _no_project(path, "its first line must be the number of meshes") from error
    rest = lines[1:]
    layers = []
    for number in range(count):
        block = rest[number * LEAST_LINES : (number + 1) * LEAST_LINES]
        if len(block) < LEAST_LINES:
            raise _no_project(path, f"it announces {count} meshes, and holds {number}")
        matrix = _matrix(path, block[0], " ".join(block[2:]))
        layers.append(ProjectLayer(_joined(path, block[0]), "", matrix))
    return Project(path, tuple(layers))


def _no_project(path: Path, what: str) -> FileError:
    return FileError(f"project {path} cannot be read: {what}; save it again with MeshLab")
