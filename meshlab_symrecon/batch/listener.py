"""Who is told how a batch goes on."""

from __future__ import annotations

from meshlab_symrecon.batch.reports import ScanReport

__all__ = ["Listener"]


class Listener:
    """Told how a batch goes on; this one keeps silent. Derive from it what shall be said."""

    def planned(self, total: int) -> None:
        """Take note of the number of scans, before anything else."""

    def ended(self, report: ScanReport) -> None:
        """Take note of one scan that is done, has failed, or was so from an earlier run."""

    def said(self, sentence: str) -> None:
        """Take note of something that the user should know."""
