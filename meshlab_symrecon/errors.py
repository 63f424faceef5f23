"""The one family of errors of this package.

Every message is one sentence: what was wrong, what was got, what to do.
"""

from __future__ import annotations

__all__ = [
    "FileError",
    "GeometryError",
    "HostError",
    "ParameterError",
    "PluginError",
    "ScriptError",
    "SizeError",
    "SymReconError",
    "SymReconWarning",
    "UnknownFilterError",
]


class SymReconError(Exception):
    """Base of every error that this package raises for a user's input."""


class ParameterError(SymReconError, ValueError):
    """A parameter has the wrong type, is out of range, or does not exist."""


class GeometryError(SymReconError, ValueError):
    """Points or faces that the algorithm cannot work on."""


class UnknownFilterError(SymReconError, LookupError):
    """No filter has that name."""


class PluginError(SymReconError):
    """A filter plugin that cannot be imported, or that clashes with another one."""


class ScriptError(SymReconError):
    """A filter script that cannot be read or run; the message starts with ``file:line:``."""


class FileError(SymReconError, OSError):
    """A file that cannot be read or written."""


class SizeError(SymReconError, MemoryError):
    """Work that would need more memory than there is, told before it starts."""


class HostError(SymReconError):
    """MeshLab refused a step; raised ``from`` the error of pymeshlab."""


class SymReconWarning(UserWarning):
    """Something the user should know; the step went on."""
