"""What became of the scans."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import Any

__all__ = [
    "CRASHED",
    "DONE",
    "FAILED",
    "KILLED",
    "NOT_WRITTEN",
    "OUT_OF_MEMORY",
    "TIMED_OUT",
    "TOO_LARGE",
    "BatchReport",
    "ScanReport",
]

DONE = "done"
FAILED = "failed"  # an error of the scan, the script or a step
NOT_WRITTEN = "not written"  # the system refused, as a full disk does
CRASHED = "crashed"
KILLED = "killed"  # from outside
TIMED_OUT, OUT_OF_MEMORY, TOO_LARGE = "timed out", "out of memory", "too large"
NOT_LOGGED = ("resumed",)


@dataclass(frozen=True, slots=True)
class ScanReport:
    """What became of one scan; its fields are those of a line of the log.

    Attributes
    ----------
    scan, output : str
        The scan's file, and the result's.
    name : str
        The result's, relative to the folder of results; the log knows a scan by it.
    status : str
        ``done``, or why there is no result: ``failed``, ``not written``, ``crashed``, ``killed``,
        ``timed out``, ``out of memory``, ``too large``.
    error : str or None
        One sentence.
    input_sha256, output_sha256 : str or None
        Checksums of the two files.
    input_files, output_files : mapping of str to str
        Checksums of the files behind them, such as the meshes of a project, materials and images;
        by their names in the same folder, or in full.
    script, script_sha256 : str, str or None
    work_sha256 : str
        Checksum of all that makes the result: script, parameters, versions.
    parameters, limits, versions, measures : mapping
    points : int or None
        Of the scan as it was read.
    steps : sequence of mapping
        What became of each step of a script.
    warnings : sequence of str
    again : str or None
        Why it was worked on although the log has a line of it.
    started : str
        UTC, as ISO 8601.
    seconds : float
    peak_memory_bytes : int
    machine : str
    resumed : bool
        Whether this comes from an earlier run's log.
    """

    scan: str
    output: str
    name: str
    status: str
    error: str | None = None
    input_sha256: str | None = None
    output_sha256: str | None = None
    input_files: Mapping[str, str | None] = field(default_factory=dict)
    output_files: Mapping[str, str | None] = field(default_factory=dict)
    script: str = ""
    script_sha256: str | None = None
    work_sha256: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    limits: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    measures: Mapping[str, Any] = field(default_factory=dict)
    points: int | None = None
    steps: Sequence[Mapping[str, Any]] = ()
    warnings: Sequence[str] = ()
    again: str | None = None
    started: str = ""
    seconds: float = 0.0
    peak_memory_bytes: int = 0
    machine: str = ""
    resumed: bool = False

    def as_data(self) -> dict[str, Any]:
        """Return it as plain data, as a line of the log has it."""
        data = asdict(self)
        for name in NOT_LOGGED:
            del data[name]
        return data

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> ScanReport:
        """Return the report that a line of a log holds; what is not known is passed over."""
        names = {known.name for known in fields(cls)} - set(NOT_LOGGED)
        known = {key: value for key, value in data.items() if key in names and value is not None}
        return cls(**known, resumed=True)


@dataclass(frozen=True, slots=True)
class BatchReport:
    """What became of a batch.

    Attributes
    ----------
    scans : tuple of ScanReport
        In the order of the scans.
    log : str
    seconds : float
    """

    scans: tuple[ScanReport, ...]
    log: str
    seconds: float

    @property
    def failed(self) -> tuple[ScanReport, ...]:
        """The scans without a result."""
        return tuple(report for report in self.scans if report.status != DONE)

    @property
    def done(self) -> tuple[ScanReport, ...]:
        """The scans with a result."""
        return tuple(report for report in self.scans if report.status == DONE)

    @property
    def resumed(self) -> int:
        """How many were so from an earlier run."""
        return sum(report.resumed for report in self.scans)

    def counts(self) -> dict[str, int]:
        """Return how many scans have each status, the most frequent first."""
        return dict(Counter(report.status for report in self.scans).most_common())

    def as_data(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        return {
            "total": len(self.scans),
            "done": len(self.done),
            "failed": len(self.failed),
            "resumed": self.resumed,
            "statuses": self.counts(),
            "seconds": self.seconds,
            "log": self.log,
            "scans": [report.as_data() | {"resumed": report.resumed} for report in self.scans],
        }
