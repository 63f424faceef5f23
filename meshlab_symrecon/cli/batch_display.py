"""How a batch goes on, and what became of it, on a terminal or in a pipe."""

from __future__ import annotations

import io
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

import click

from meshlab_symrecon.batch import BatchReport, Listener, ScanReport
from meshlab_symrecon.batch.reports import DONE

if TYPE_CHECKING:
    from rich.progress import Progress

__all__ = ["Counting", "display", "found_in_words", "in_a_line", "print_table"]

IN_A_PIPE = 10_000  # columns, so that nothing is cut
SHOWN = 3  # measures of a script
WARNED = 3  # warnings of a scan


@contextmanager
def display(quiet: bool) -> Iterator[Counting]:
    """Yield what tells of the progress: a bar on a terminal, lines in a pipe."""
    if quiet:
        yield Counting()
    elif sys.stderr.isatty():
        with _bar() as listener:
            yield listener
    else:
        yield _Lines()


class Counting(Listener):
    """Counts, and says nothing."""

    def __init__(self) -> None:
        self.total = self.count = self.failed = self.resumed = 0

    def planned(self, total: int) -> None:
        """Take note of the number of scans."""
        self.total = total

    def ended(self, report: ScanReport) -> None:
        """Count a scan, and tell of it when it is of this run."""
        self.count += 1
        self.failed += report.status != DONE
        self.resumed += report.resumed
        if not report.resumed:
            self.new(report)

    def new(self, report: ScanReport) -> None:
        """Tell of a scan of this run."""


class _Lines(Counting):
    """One line a scan."""

    def said(self, sentence: str) -> None:
        click.echo(in_a_line(sentence), err=True)

    def new(self, report: ScanReport) -> None:
        click.echo(f"[{self.count}/{self.total}] {_told(report)}", err=True)
        for sentence in _warned(report):
            click.echo(f"  {sentence}", err=True)


class _Bar(Counting):
    """A bar with counts and the time left; what has failed or has warnings is told above it."""

    def __init__(self, bar: Progress) -> None:
        super().__init__()
        self.bar, self.task = bar, bar.add_task("checking", total=None)

    def planned(self, total: int) -> None:
        super().planned(total)
        self.bar.update(self.task, total=total)

    def ended(self, report: ScanReport) -> None:
        super().ended(report)
        words = f"{self.count - self.failed} done, {self.failed} failed"
        if report.resumed:  # it says nothing on the time that the others will take
            self.bar.reset(self.task, total=self.total, completed=self.count, description=words)
        else:
            self.bar.update(self.task, completed=self.count, description=words)

    def new(self, report: ScanReport) -> None:
        if report.status != DONE or report.warnings:
            self.said(_told(report))
        for sentence in _warned(report):
            self.said(f"  {sentence}")

    def said(self, sentence: str) -> None:
        self.bar.console.print(in_a_line(sentence), markup=False, highlight=False, soft_wrap=True)


@contextmanager
def _bar() -> Iterator[Counting]:
    from rich import progress
    from rich.console import Console

    columns = (
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TextColumn("{task.description}"),
        progress.TimeElapsedColumn(),
        progress.TextColumn("left"),
        progress.TimeRemainingColumn(),
    )
    with progress.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        yield _Bar(bar)


def in_a_line(text: str) -> str:
    """Return a text in which what no line can show, as line feeds in names, is written out."""
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode("ascii")
        for sign in text
    )


def _told(report: ScanReport) -> str:
    if report.status == DONE:
        return in_a_line(f"done {report.scan}: {report.seconds:.1f} s")
    error = report.error or ""
    named = error if error.startswith(report.scan) else f"{report.scan}: {error}"
    return in_a_line(f"{report.status} {named}")


def _warned(report: ScanReport) -> list[str]:
    """Return the first warnings of a scan."""
    lines = [in_a_line(f"warning: {sentence}") for sentence in report.warnings[:WARNED]]
    more = len(report.warnings) - len(lines)
    return [*lines, f"and {more} more in the log"] if more else lines


def print_table(report: BatchReport) -> None:
    """Print one row a scan, and a last line that sums up."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("scan", overflow="fold")
    table.add_column("status", no_wrap=True)
    table.add_column("seconds", justify="right", no_wrap=True)
    table.add_column("memory", justify="right", no_wrap=True)
    table.add_column("found", overflow="fold")
    for one in report.scans:
        style = "" if one.status == DONE else "red"
        memory = f"{one.peak_memory_bytes / 2**20:.0f} MB"
        cells = (one.scan, one.status, f"{one.seconds:.1f}", memory, found_in_words(one))
        table.add_row(*(Text(in_a_line(cell), style=style) for cell in cells))
    if sys.stdout.isatty():
        Console().print(table)
    else:
        text = io.StringIO()
        Console(file=text, width=IN_A_PIPE, color_system=None).print(table)
        click.echo("\n".join(line.rstrip() for line in text.getvalue().splitlines()))
    click.echo(in_a_line(_sum(report)))


def _sum(report: BatchReport) -> str:
    words = ", ".join(f"{count} {status}" for status, count in report.counts().items())
    warned = sum(bool(report.warnings) for report in report.scans)
    warnings = f", {warned} with warnings" if warned else ""
    earlier = f" ({report.resumed} from an earlier run)" if report.resumed else ""
    scans = "1 scan" if len(report.scans) == 1 else f"{len(report.scans)} scans"
    return f"{scans}: {words}{warnings}{earlier} in {report.seconds:.1f} s, logged in {report.log}"


def found_in_words(report: ScanReport) -> str:
    """Return in a few words what was found, or the sentence of the error."""
    if report.status != DONE:
        return report.error or ""
    measures = report.measures
    if "surface" in measures and "planes" in measures:
        # Unless somebody has edited the log.
        with suppress(LookupError, TypeError, ValueError, RecursionError):
            return _of_method(measures)
    numbers = [
        f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in measures.items()
        if isinstance(value, (bool, int, float, str))
    ]
    skipped = sum(step.get("status") == "skipped" for step in report.steps)
    steps = "1 step" if len(report.steps) == 1 else f"{len(report.steps)} steps"
    first = [steps + (f" ({skipped} skipped)" if skipped else "")]
    return ", ".join(first + numbers[:SHOWN])


def _of_method(measures: Mapping[str, Any]) -> str:
    planes, surface = measures["planes"], measures["surface"]
    if planes:
        plane = f"mirror plane of confidence {planes[0]['confidence']:.2f}"
        mirrored = f"{measures['mirrored']} points mirrored"
        words = [plane if len(planes) == 1 else f"{len(planes)} planes, first a {plane}", mirrored]
    else:
        words = ["no mirror plane"]
    closed = "closed" if surface["closed"] else "NOT closed"
    return ", ".join([*words, f"{closed}, genus {surface['genus']}, {surface['faces']} faces"])
