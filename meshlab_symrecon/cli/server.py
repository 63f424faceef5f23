"""``symrecon-server``: the command lines of ``meshlabserver``, on what MeshLab is today."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

import click

from meshlab_symrecon import __version__
from meshlab_symrecon.cli.border import DONE, exit_with
from meshlab_symrecon.cli.server_arguments import parse
from meshlab_symrecon.cli.server_checks import Checked, check, check_on_document
from meshlab_symrecon.cli.server_help import HELP
from meshlab_symrecon.cli.server_job import Job
from meshlab_symrecon.cli.server_journal import journal_of

__all__ = ["main", "serve"]

LOUD = "default.debug=true"  # for Qt, whose messages carry the log of the filters


def main(words: Sequence[str] | None = None) -> NoReturn:
    """Run a command line and exit: 0 done, 1 an error, 2 wrong usage."""
    given = sys.argv[1:] if words is None else list(words)
    os.environ["QT_LOGGING_RULES"] = LOUD  # before anything imports pymeshlab
    exit_with(lambda: serve(given))


def serve(words: Sequence[str]) -> int:
    """Run a command line; return its exit code.

    Raises
    ------
    click.UsageError
        The command line is wrong.
    SymReconError
        A file or a script has a mistake, and nothing was touched; or a step failed, and nothing
        was written.
    """
    job = parse(words)
    if job.help:
        click.echo(HELP, nl=False)
        return DONE
    if job.version:
        click.echo(f"symrecon-server {__version__}")
        return DONE
    if job.list_filters:
        from meshlab_symrecon.cli.filters import filters

        filters.main(["--all"], standalone_mode=False)
    checked = check(job)
    if job.dry_run:
        findings = _tried(job, checked)
        _say_plan(job, checked, findings)
        return DONE
    with journal_of(words, job.log) as journal:
        from meshlab_symrecon.cli.server_run import run_job

        for note in job.notes:
            journal.say(note)
        return run_job(job, checked, journal)


def _tried(job: Job, checked: Checked) -> tuple[Any, ...]:
    """Load what a job names, and check its scripts on that; return what was found, but errors."""
    from meshlab_symrecon.cli.server_run import identifier_of, load_item
    from meshlab_symrecon.host.files import new_document
    from meshlab_symrecon.host.native_log import native_log

    mesh_set = new_document()
    with native_log(mesh_set):
        for load in job.loads:
            load_item(load, checked, mesh_set)
        if not job.scripts:
            for output in job.outputs:
                identifier_of(mesh_set, output)
        return check_on_document(job, checked, mesh_set)


def _say_plan(job: Job, checked: Checked, findings: tuple[Any, ...]) -> None:
    for load in job.loads:
        click.echo(f"{load.path}: would be loaded")
    for script in checked.scripts:
        count = len(script.steps)
        click.echo(f"{script.path}: {count} step{'' if count == 1 else 's'} would run")
    for finding in (*checked.findings, *findings):
        click.echo(f"    {finding}")
    targets = [project.path for project in job.projects] + [output.path for output in job.outputs]
    for path in (*targets, job.dump, job.report, job.log):
        if path is not None:
            click.echo(f"{path}: would be written")


if __name__ == "__main__":
    main()
