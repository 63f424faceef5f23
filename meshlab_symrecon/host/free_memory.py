"""How much memory this process may still use."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

__all__ = ["available_memory", "used_memory"]

ROOT = Path("/")
KIBIBYTE = 1024
UNLIMITED = 1 << 60  # bytes; version 1 of the control groups writes a number near 2^63 for it


def available_memory(root: Path = ROOT) -> int:
    """Return the bytes that this process may still use.

    That is the least of what the machine has free, what the control groups of a container leave,
    and what the limits of the process leave. ``sys.maxsize`` where nothing of it is known.

    Parameters
    ----------
    root : Path
        Where ``proc`` and ``sys`` are.
    """
    known = [*_of_machine(root), *_of_groups(root), *_of_limits(root)]
    return max(0, min(known, default=sys.maxsize))


def used_memory(root: Path = ROOT) -> int:
    """Return the bytes of memory that this process holds; 0 where that is not known."""
    held = _field(root / "proc/self/status", "VmRSS:")
    if held is not None:
        return held * KIBIBYTE
    try:
        return int(import_module("psutil").Process().memory_info().rss)
    except ImportError:
        return 0


def _of_machine(root: Path) -> Iterator[int]:
    free = _field(root / "proc/meminfo", "MemAvailable:")
    if free is not None:
        yield free * KIBIBYTE
        return
    try:
        yield int(import_module("psutil").virtual_memory().available)
    except ImportError:
        if "SC_PHYS_PAGES" in getattr(os, "sysconf_names", {}):
            yield os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _of_groups(root: Path) -> Iterator[int]:
    """Yield what each control group that holds this process leaves it."""
    for line in _text(root / "proc/self/cgroup").splitlines():
        _, _, rest = line.partition(":")
        controllers, _, path = rest.partition(":")
        if controllers == "":
            top, names = root / "sys/fs/cgroup", ("memory.max", "memory.high", "memory.current")
        elif "memory" in controllers.split(","):
            top = root / "sys/fs/cgroup/memory"
            names = ("memory.limit_in_bytes", "", "memory.usage_in_bytes")
        else:
            continue
        for folder in _upwards(top, path):
            yield from _left_in(folder, names)


def _upwards(top: Path, path: str) -> Iterator[Path]:
    """Yield a group's folder and those above it; inside a container only the top is there."""
    parts = [part for part in path.split("/") if part not in ("", ".", "..")]
    for count in range(len(parts), -1, -1):
        yield top.joinpath(*parts[:count])


def _left_in(folder: Path, names: tuple[str, str, str]) -> Iterator[int]:
    *limits, usage = names
    used = _number(folder / usage)
    if used is None:
        return
    cached = 0
    for field in ("total_inactive_file", "inactive_file"):  # given back when memory is short
        cached = max(cached, _field(folder / "memory.stat", field) or 0)
    for name in limits:
        limit = _number(folder / name) if name else None
        if limit is not None and limit < UNLIMITED:
            yield limit - max(0, used - cached)


def _of_limits(root: Path) -> Iterator[int]:
    try:
        resource = import_module("resource")
    except ImportError:  # on Windows
        return
    for limit, field in (("RLIMIT_AS", "VmSize:"), ("RLIMIT_DATA", "VmData:")):
        if not hasattr(resource, limit):
            continue
        most = resource.getrlimit(getattr(resource, limit))[0]
        if most != resource.RLIM_INFINITY:
            used = _field(root / "proc/self/status", field) or 0
            yield int(most) - used * KIBIBYTE


def _field(path: Path, name: str) -> int | None:
    """Return the number behind a name in a file of lines."""
    for line in _text(path).splitlines():
        words = line.split()
        if len(words) > 1 and words[0] == name and words[1].isdecimal():
            return int(words[1])
    return None


def _number(path: Path) -> int | None:
    text = _text(path).strip()
    return int(text) if text.isdecimal() else None


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
