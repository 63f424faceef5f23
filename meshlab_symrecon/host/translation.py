"""The one place where an exception of pymeshlab becomes one of ours."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterator
from contextlib import contextmanager

import pymeshlab

from meshlab_symrecon.errors import HostError, ParameterError, SymReconError
from meshlab_symrecon.host.aftermath import aftermath_undone

__all__ = ["script_name_in_python", "translated"]

_SEPARATORS = str.maketrans({" ": "_", "/": "_", "-": "_"} | dict.fromkeys("().,'\":+", ""))
# The step is named in front; MeshLab's "Details: " starts what is worth saying.
REPEATED = re.compile(r"^Failed to apply filter: '?\w+[.']*\s+(?:Details: )?")
_PARAMETER_WORDS = ("Parameter ", "Unable to cast Python instance")


@contextmanager
def translated(step: str) -> Iterator[None]:
    """Run calls of pymeshlab; raise what they raise as one sentence that starts with ``step``.

    pymeshlab raises five unrelated children of ``Exception``, and bare ``RuntimeError`` for a value
    of the wrong Python type.

    Raises
    ------
    ParameterError
        MeshLab did not accept a parameter.
    HostError
        MeshLab refused the step for any other reason.
    """
    try:
        with aftermath_undone():
            yield
    except SymReconError:
        raise
    except pymeshlab.InvalidEnumException as error:
        raise ParameterError(f"{step}: {_one_line(error)}") from error
    except Exception as error:
        message = f"{step}: {_one_line(error)}"
        if str(error).startswith(_PARAMETER_WORDS):
            raise ParameterError(message) from error
        raise HostError(message) from error


def _one_line(error: Exception) -> str:
    """Return MeshLab's words without its line breaks and its invitation to report a bug."""
    words = " ".join(str(error).split())
    words = REPEATED.sub("", words.partition(" (#define PYBIND11")[0])
    if words.startswith("Something really bad happened"):
        return "MeshLab failed without naming a reason; check the input of the filter"
    return words.rstrip(" .;") or f"MeshLab raised {type(error).__name__} without a reason"


def script_name_in_python(name: str) -> str:
    """Return the Python name of a parameter's name in scripts, by pymeshlab's rule."""
    plain = name.lower().translate(_SEPARATORS)
    return plain + "_" if keyword.iskeyword(plain) else plain
