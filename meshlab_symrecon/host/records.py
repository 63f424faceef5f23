"""What a result is made of: versions, inputs and every step with its parameters."""

from __future__ import annotations

import math
import platform
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.host.atomic import reason
from meshlab_symrecon.host.checksums import sha256_of
from meshlab_symrecon.host.exact_steps import CHANGE_NAME
from meshlab_symrecon.host.filter_names import known_today
from meshlab_symrecon.host.mlx import Step as ScriptStep
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.old_names import CHANGE_LAYER
from meshlab_symrecon.host.record_text import Input, Record, Step, read_record
from meshlab_symrecon.host.recorded_values import recorded_values
from meshlab_symrecon.host.script_history import recorded_script
from meshlab_symrecon.host.versions import versions_of_results

__all__ = ["Input", "Record", "Step", "read_record", "record_of", "versions"]


def versions() -> dict[str, str]:
    """Return the versions of what results are made with, and of Python."""
    return versions_of_results() | {"python": platform.python_version()}


def record_of(
    mesh_set: Any, inputs: Sequence[Path], parameters: Mapping[str, Any] | None = None
) -> Record:
    """Return how what is in a MeshSet came about: the same for the same work anywhere.

    Nothing in it tells of the machine, the folders or the time.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
        Its filter history is the steps; those of all layers.
    inputs : sequence of Path
        The files that were read. The record in one of them, where it has one, goes along.
    parameters : mapping, optional
        Settings of a command that are no parameters of a step, as plain data.

    Raises
    ------
    FileError
        An input cannot be read.

    Warns
    -----
    SymReconWarning
        The record in an input is damaged, and does not go along.
    """
    return Record(
        versions=versions_of_results(),  # not that of Python: no number depends on it
        inputs=tuple(_input(Path(path)) for path in inputs),
        parameters=_plain(parameters or {}),
        steps=tuple(_step(step) for step in recorded_script(mesh_set).steps),
    )


def _input(path: Path) -> Input:
    try:
        checksum = sha256_of(path)
    except OSError as error:
        raise FileError(f"{path} cannot be read: {reason(error)}; check its path") from error
    try:
        earlier = read_record(path)
    except FileError as error:
        warn_user(f"{error}; it does not go along")
        earlier = None
    return Input(path.name, checksum, earlier)


def _step(step: ScriptStep) -> Step:
    known = known_today(step.name)
    name = step.name if known is None else known.python_name
    values = recorded_values(step, folders=False)
    return Step(CHANGE_LAYER if name == CHANGE_NAME else name, values)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return _plain(value.tolist()) if hasattr(value, "tolist") else str(value)
