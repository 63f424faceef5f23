"""The textures of a layer, written beside its file."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from meshlab_symrecon.host.atomic import same_file
from meshlab_symrecon.host.notices import warn_user

__all__ = ["write_textures"]


def write_textures(mesh: Any, path: Path, staging: Path, sources: Mapping[str, Path]) -> None:
    """Write the textures of a layer that is saved as ``path`` into a directory.

    Parameters
    ----------
    mesh : pymeshlab.Mesh
    path : Path
        Where the layer goes; a texture that already lies there beside it is left alone.
    staging : Path
        The directory. A texture in a folder of its own is written into one of that name.
    sources : mapping of str to Path
        Files to copy instead of writing the texture of that name anew.

    Warns
    -----
    SymReconWarning
        The name of a texture leads elsewhere; that file is neither copied nor changed.
    """
    for name, image in mesh.textures().items():
        if _leads_elsewhere(name):
            warn_user(f"{path}: its texture '{name}' lies elsewhere, and was left where it is")
            continue
        source = sources.get(name)
        target = staging / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if source is None or not source.is_file():
            image.save(str(target))
        elif not same_file(source, path.parent / name):
            shutil.copyfile(source, target)


def _leads_elsewhere(name: str) -> bool:
    kinds = (PurePosixPath(name), PureWindowsPath(name))
    return any(kind.is_absolute() or kind.drive or ".." in kind.parts for kind in kinds)
