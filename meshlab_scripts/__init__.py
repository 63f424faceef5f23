"""The filter scripts that come with meshlab_symrecon, as files that every program can read."""

from __future__ import annotations

from pathlib import Path

from meshlab_symrecon.errors import FileError

__all__ = ["script_names", "script_path"]

FOLDER = Path(__file__).parent


def script_names() -> list[str]:
    """Return the names of the scripts, without their ending, in order."""
    return sorted(path.stem for path in FOLDER.glob("*.mlx"))


def script_path(name: str) -> Path:
    """Return where a script is.

    Parameters
    ----------
    name : str
        With or without its ending.

    Raises
    ------
    FileError
        No script has that name; the message lists those there are.
    """
    names = script_names()
    if name.removesuffix(".mlx") not in names:
        raise FileError(f"no script that comes with us is named {name!r}; say {', '.join(names)}")
    return FOLDER / f"{name.removesuffix('.mlx')}.mlx"
