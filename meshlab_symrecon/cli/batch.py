"""``symrecon batch``: many scans through one script, or through the whole method."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from meshlab_symrecon.cli.border import DONE, FAILED, OF_SIGNALS
from meshlab_symrecon.cli.file_path import FilePath
from meshlab_symrecon.host.fewest_points import FEWEST_POINTS

if TYPE_CHECKING:
    from meshlab_symrecon.batch import Batch, BatchReport, Limits
    from meshlab_symrecon.cli.batch_display import Counting

__all__ = ["batch"]

RECONSTRUCT = "reconstruct"
SIGNALS = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]
SEED_LIMIT = 2**31 - 1


@click.command()
@click.argument("script", type=click.Path(), metavar="SCRIPT.mlx")
@click.argument("inputs", nargs=-1, required=True, type=click.Path(), metavar="IN...")
@click.option(
    "-d", "--directory", "folder", type=click.Path(), required=True,
    metavar="OUTDIR", help="Folder of the results; it is made when it is missing.",
)  # fmt: skip
@click.option(
    "--name", default="{stem}.ply", show_default=True, metavar="TEMPLATE",
    help="Name of each result, with {stem} {extension} {parent} {folder} {number} {script}.",
)  # fmt: skip
@click.option("--recursive", is_flag=True, help="Look into folders in folders.")
@click.option(
    "--jobs", type=click.IntRange(1), metavar="N",
    help="How many scans at once; as many as there are cores when left out.",
)  # fmt: skip
@click.option(
    "--threads", type=click.IntRange(1), metavar="N",
    help="Threads of each scan; 1 when several scans are worked on at once.",
)  # fmt: skip
@click.option(
    "--time-limit", "seconds", type=click.FloatRange(0, min_open=True), metavar="SECONDS",
    help="End a scan that takes longer.",
)  # fmt: skip
@click.option("--memory-limit", "memory", metavar="4G", help="End a scan that needs more.")
@click.option(
    "--max-points", "points", type=click.IntRange(FEWEST_POINTS), metavar="N",
    help="Thin a scan with more points out evenly to these first.",
)  # fmt: skip
@click.option(
    "--scheduler", metavar="ADDRESS",
    help="Work on the cluster of this dask scheduler, such as tcp://host:8786.",
)  # fmt: skip
@click.option(
    "--log", type=FilePath(), metavar="FILE.jsonl",
    help="One line of JSON a scan; OUTDIR/batch.jsonl when left out.",
)  # fmt: skip
@click.option(
    "--json", "summary", type=FilePath(), metavar="R.json",
    help="Also save what became of all scans.",
)  # fmt: skip
@click.option("--retry", is_flag=True, help="Work again on scans that have failed before.")
@click.option("--again", is_flag=True, help="Work again on every scan.")
@click.option("--strict", is_flag=True, help="Refuse a script that is not quite of today.")
@click.option("--lenient", is_flag=True, help="Pass over steps that cannot run, and say which.")
@click.option(
    "--seed", "randomseed", type=click.IntRange(0, SEED_LIMIT),
    help="For reconstruct: seed of what is random; 0 when left out.",
)  # fmt: skip
@click.option(
    "--paint", is_flag=True,
    help="For reconstruct: colour by what was measured and what was invented.",
)  # fmt: skip
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")
def batch(**given: Any) -> int:
    """Run a script, or the word "reconstruct" for the whole method, on every scan in IN...

    IN are files, folders, and quoted patterns such as 'scans/**/*.ply'. Each scan is worked on in
    a process of its own: one that fails, or crashes, is reported, and the rest go on. The same
    command goes on where it stopped.

    Exit codes: 0 every scan has a result, 1 some have none (or an error of the whole batch), 2
    wrong usage, 130 interrupted (143 by SIGTERM).
    """
    from meshlab_symrecon.batch import run_batch
    from meshlab_symrecon.cli.batch_display import display, in_a_line, print_table
    from meshlab_symrecon.host.interruption import signal_of_interruption

    quiet = _with_options_before(given)
    summary: Path | None = given["summary"]
    asked = _asked(**given)
    with display(quiet) as listener:
        try:
            with _time_to_tidy_up():
                report = run_batch(asked, listener)
        except (KeyboardInterrupt, Exception):  # libraries make others of an interruption
            if not signal_of_interruption():
                raise
            return _interrupted(listener)
    if summary is not None:
        from meshlab_symrecon.cli.reports import write_json

        write_json(summary, report.as_data())
    if not quiet:
        print_table(report)
    if not report.failed:
        return DONE
    click.echo(in_a_line(f"error: {_failures(report)}"), err=True)
    return FAILED


def _with_options_before(given: dict[str, Any]) -> bool:
    """Take what stands before the command's name where the command has nothing; return quiet."""
    before = click.get_current_context().find_root().params
    if before.get("log") is not None:
        message = "--log before 'batch' is a log for people, and batches keep none"
        raise click.UsageError(f"{message}; give --log FILE.jsonl behind it")
    if given["threads"] is None:
        given["threads"] = before.get("threads")
    return bool(given.pop("quiet") or before.get("quiet"))


def _interrupted(listener: Counting) -> int:
    from meshlab_symrecon.host.interruption import signal_of_interruption

    done = f"{listener.count} of {listener.total} scans are done" if listener.total else "no work"
    click.echo(f"interrupted; {done}, and the same command goes on", err=True)
    return OF_SIGNALS + signal_of_interruption()


def _asked(
    *,
    script: str,
    strict: bool,
    lenient: bool,
    randomseed: int | None,
    paint: bool,
    jobs: int | None,
    scheduler: str | None,
    **others: Any,
) -> Batch:
    """Return the batch of a command line; usage errors for what does not fit together."""
    from meshlab_symrecon.batch import Batch

    settings: dict[str, object] = {}
    if script == RECONSTRUCT:
        if strict or lenient:
            raise click.UsageError("--strict and --lenient are for scripts, not for reconstruct")
        settings = {"randomseed": randomseed or 0, "paint": paint}
    elif randomseed is not None or paint:
        raise click.UsageError("--seed and --paint are for reconstruct; write them in the script")
    if strict and lenient:
        raise click.UsageError("--strict and --lenient contradict each other; give one")
    if jobs is not None and scheduler is not None:
        raise click.UsageError("--jobs is for this machine; a cluster's workers say how many")
    limits = _limits(**{name: others.pop(name) for name in ("seconds", "memory", "points")},
                     threads=others.pop("threads"))  # fmt: skip
    return Batch(
        script, settings=settings, strict=strict, lenient=lenient, jobs=jobs, scheduler=scheduler,
        limits=limits, **others,
    )  # fmt: skip


def _limits(
    seconds: float | None, memory: str | None, points: int | None, threads: int | None
) -> Limits:
    from meshlab_symrecon.batch import Limits
    from meshlab_symrecon.batch.request import bytes_of
    from meshlab_symrecon.errors import ParameterError

    try:
        size = None if memory is None else bytes_of(memory)
    except ParameterError as error:
        raise click.BadParameter(str(error), param_hint="'--memory-limit'") from error
    try:
        return Limits(seconds, size, points, threads)
    except ParameterError as error:  # the others are checked: it is no number, or infinite
        raise click.BadParameter(str(error), param_hint="'--time-limit'") from error


def _failures(report: BatchReport) -> str:
    counts = ", ".join(
        f"{count} {status}" for status, count in report.counts().items() if status != "done"
    )
    from meshlab_symrecon.batch.reports import TOO_LARGE

    what = "1 scan has" if len(report.scans) == 1 else f"{len(report.scans)} scans have"
    unchanged = any(one.status != TOO_LARGE for one in report.failed)
    retry = "; --retry tries even what is as it was" if unchanged else ""
    return (
        f"{len(report.failed)} of {what} no result ({counts}); {report.log} says why, and the same "
        f"command goes on once that is mended{retry}"
    )


@contextmanager
def _time_to_tidy_up() -> Iterator[None]:
    """Answer a signal at once: several processes have to be ended, which we see to ourselves."""
    from meshlab_symrecon.host.interruption import interruption_settled

    def answered(before: Any) -> Any:
        def handler(number: int, frame: Any) -> None:
            interruption_settled()
            before(number, frame)

        return handler

    known = {number: signal.getsignal(number) for number in SIGNALS}
    ours = {number: before for number, before in known.items() if callable(before)}
    try:
        for number, before in ours.items():
            signal.signal(number, answered(before))
        yield
    finally:
        for number, before in ours.items():
            signal.signal(number, before)
