"""``symrecon-server``: the command lines of ``meshlabserver``, on what MeshLab is today."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

import click

from meshlab_symrecon import __version__
from meshlab_symrecon.cli.border import DONE, FAILED, exit_with
from meshlab_symrecon.cli.server_arguments import parse
from meshlab_symrecon.cli.server_checks import Checked, check, check_on_document
from meshlab_symrecon.cli.server_help import HELP
from meshlab_symrecon.cli.server_job import CURRENT, LAST, Job, Load, Output
from meshlab_symrecon.cli.server_journal import Journal, journal_of
from meshlab_symrecon.errors import FileError, SymReconError

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
        for note in job.notes:
            journal.say(note)
        return _Run(job, checked, journal).all()


def _tried(job: Job, checked: Checked) -> tuple[Any, ...]:
    """Load what a job names, and check its scripts on that; return what was found, but errors."""
    from meshlab_symrecon.host.files import new_document
    from meshlab_symrecon.host.native_log import native_log

    mesh_set = new_document()
    with native_log(mesh_set):
        for load in job.loads:
            _load(load, checked, mesh_set)
        if not job.scripts:
            for output in job.outputs:
                _identifier_of(mesh_set, output)
        return check_on_document(job, checked, mesh_set)


def _load(item: Load, checked: Checked, mesh_set: Any) -> dict[int, Path]:
    """Load a file or a project; return the file of each new layer, by its identifier."""
    from meshlab_symrecon.host.files import load
    from meshlab_symrecon.host.interruption import now_doing
    from meshlab_symrecon.host.projects import load_layers

    now_doing(f"reading {item.path}")
    if item.project:
        return load_layers(checked.projects[item.path], mesh_set)
    before = {int(mesh.id()) for mesh in mesh_set}
    load(item.path, mesh_set)
    added = {int(mesh.id()) for mesh in mesh_set} - before
    return dict.fromkeys(sorted(added), item.path)


def _identifier_of(mesh_set: Any, output: Output) -> int:
    """Return the identifier of the layer that an output means."""
    from meshlab_symrecon.host.meshset import current_identifier

    identifiers = [int(mesh.id()) for mesh in mesh_set]
    if not identifiers:
        raise FileError(f"{output.path} cannot be written: there is no layer; load one (-i)")
    if output.layer == CURRENT:
        return current_identifier(mesh_set)
    if output.layer == LAST:
        return identifiers[-1]
    position = int(output.layer)
    if position >= len(identifiers):
        message = (
            f"{output.path} cannot be written: there is no layer {position} (-l); the document "
            f"has layers 0 to {len(identifiers) - 1}"
        )
        raise FileError(message)
    return identifiers[position]


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


class _Run:
    """One job that was checked, on one document."""

    def __init__(self, job: Job, checked: Checked, journal: Journal) -> None:
        from meshlab_symrecon.host.files import new_document

        self.job = job
        self.checked = checked
        self.journal = journal
        self.mesh_set = new_document()
        self.origins: dict[int, Path] = {}  # the file of each layer that was loaded
        self.reports: list[Any] = []
        self.files: list[dict[str, Any]] = []
        self.started = time.perf_counter()

    def all(self) -> int:
        from meshlab_symrecon.host.native_log import native_log

        self.dump()
        with native_log(self.mesh_set) as log:
            return self.work(log)

    def work(self, log: Any) -> int:
        for load in self.job.loads:
            self.load(load)
        if not self.job.scripts:
            self.check_layers()
        check_on_document(self.job, self.checked, self.mesh_set)
        self.run_scripts(log)
        if self.job.bake:
            self.bake()
        done = [self.save_project(number) for number in range(len(self.job.projects))]
        done += [self.save(output) for output in self.job.outputs]
        code = DONE if all(done) else FAILED
        self.report(code)
        return code

    def dump(self) -> None:
        if self.job.dump is not None:
            from meshlab_symrecon.cli.server_dump import write_dump

            count = write_dump(self.job.dump)
            self.journal.say(f"{count} filters written to {self.job.dump}")

    def load(self, item: Load) -> None:
        before = {int(mesh.id()) for mesh in self.mesh_set}
        self.origins |= _load(item, self.checked, self.mesh_set)
        for position, mesh in enumerate(self.mesh_set):
            if mesh.id() not in before:
                size = f"{mesh.vertex_number()} vn {mesh.face_number()} fn"
                self.journal.say(f"{self.origins[mesh.id()]} loaded as layer {position} ({size})")

    def check_layers(self) -> None:
        """Refuse layers that do not exist before anything is written; scripts may make some."""
        for output in self.job.outputs:
            _identifier_of(self.mesh_set, output)

    def run_scripts(self, log: Any) -> None:
        from meshlab_symrecon.host.interruption import telling
        from meshlab_symrecon.host.script import run_steps

        for script in self.checked.scripts:
            with log.listening(self.journal.say) as relay:
                result = run_steps(
                    self.mesh_set, script,
                    strict=self.job.strict, lenient=self.job.lenient,
                    progress=telling(relay),
                )  # fmt: skip
            self.reports.append(result)
            for step in result.steps:
                self.say_step(step)

    def say_step(self, step: Any) -> None:
        place = f"{step.file}:{step.line}"
        self.journal.say(f"{place}: {step.status} {step.name.strip()} ({step.seconds:.2f} s)")
        for note in step.notes:
            self.journal.say(f"    {note}")

    def bake(self) -> None:
        from meshlab_symrecon.host.baking import bake_layer

        for identifier in [int(mesh.id()) for mesh in self.mesh_set]:
            bake_layer(self.mesh_set, identifier)

    def save_project(self, number: int) -> bool:
        from meshlab_symrecon.host.interruption import now_doing
        from meshlab_symrecon.host.project_copy import copied_files, save_project_copy

        wanted = self.job.projects[number]
        now_doing(f"writing {wanted.path}")
        middle = "" if wanted.overwrite else "_out" + (str(number) if number else "")
        labels = {int(mesh.id()): mesh.label() for mesh in self.mesh_set}
        files = copied_files(wanted.path, labels, self.origins, middle)
        record = {"path": str(wanted.path), "layers": [str(file) for file in files.values()]}
        try:
            save_project_copy(self.mesh_set, wanted.path, files)
        except SymReconError as error:
            return self.failed(record, error)
        for file in files.values():
            self.journal.say(f"layer saved as {file}")
        self.journal.say(f"project saved as {wanted.path}")
        self.files.append(record | {"written": True})
        return True

    def save(self, output: Output) -> bool:
        record: dict[str, Any] = {"path": str(output.path), "flags": sorted(output.mask)}
        try:
            identifier = _identifier_of(self.mesh_set, output)
            self.export(identifier, output)
        except SymReconError as error:
            return self.failed(record, error)
        mesh = self.mesh_set.mesh(identifier)
        points, faces = mesh.vertex_number(), mesh.face_number()
        self.journal.say(f"layer '{mesh.label()}' saved as {output.path} ({points} vn {faces} fn)")
        self.files.append(
            record | {"written": True, "layer": mesh.label(), "points": points, "faces": faces}
        )
        return True

    def export(self, identifier: int, output: Output) -> None:
        from meshlab_symrecon.host.atomic import replacing
        from meshlab_symrecon.host.export import export_layer, write_all
        from meshlab_symrecon.host.interruption import now_doing
        from meshlab_symrecon.host.mask import TEXT, passed_over, save_options
        from meshlab_symrecon.host.notices import warn_user

        now_doing(f"writing {output.path}")
        extension = output.path.suffix.removeprefix(".").lower()
        lost = passed_over(extension, output.mask)
        if lost:
            warn_user(f"{output.path}: .{extension} holds no {', '.join(lost)}; they were left out")
        if self.job.keep_all:
            with replacing(output.path) as staged:
                text = TEXT in output.mask
                write_all(self.mesh_set, identifier, output.path, staged, text)
        else:
            options = save_options(extension, output.mask)
            export_layer(self.mesh_set, identifier, output.path, options)

    def failed(self, record: dict[str, Any], error: SymReconError) -> bool:
        self.journal.complain(str(error))
        self.files.append(record | {"written": False, "error": str(error)})
        return False

    def report(self, code: int) -> None:
        if self.job.report is None:
            return
        from meshlab_symrecon.cli.reports import write_json

        data = {
            "inputs": [str(load.path) for load in self.job.loads],
            "scripts": self.reports,
            "outputs": self.files,
            "notes": list(self.job.notes),
            "seconds": time.perf_counter() - self.started,
            "exit_code": code,
        }
        write_json(self.job.report, data)


if __name__ == "__main__":
    main()
