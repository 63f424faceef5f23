"""One job of ``symrecon-server``, done: layers loaded, scripts run, results written."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from meshlab_symrecon.cli.border import DONE, FAILED
from meshlab_symrecon.cli.reports import write_json
from meshlab_symrecon.cli.server_checks import Checked, check_on_document
from meshlab_symrecon.cli.server_job import CURRENT, LAST, Job, Load, Output
from meshlab_symrecon.cli.server_journal import Journal
from meshlab_symrecon.errors import FileError, SymReconError
from meshlab_symrecon.host.atomic import replacing
from meshlab_symrecon.host.baking import bake_layer
from meshlab_symrecon.host.export import export_layer, write_all
from meshlab_symrecon.host.files import load, new_document
from meshlab_symrecon.host.interruption import now_doing, telling
from meshlab_symrecon.host.mask import TEXT, passed_over, save_options
from meshlab_symrecon.host.meshset import current_identifier
from meshlab_symrecon.host.native_log import native_log
from meshlab_symrecon.host.notices import warn_user
from meshlab_symrecon.host.project_copy import copied_files, save_project_copy
from meshlab_symrecon.host.projects import load_layers
from meshlab_symrecon.host.script import run_steps

__all__ = ["identifier_of", "load_item", "run_job"]


def run_job(job: Job, checked: Checked, journal: Journal) -> int:
    """Do a job; return the exit code: 0, or 1 when some results could not be written.

    Raises
    ------
    SymReconError
        A file cannot be read or a step failed, and nothing was written.
    """
    return _Run(job, checked, journal).all()


def load_item(item: Load, checked: Checked, mesh_set: Any) -> dict[int, Path]:
    """Load a file or a project; return the file of each new layer, by its identifier.

    Raises
    ------
    FileError
        As ``load`` and ``load_layers``.
    """
    now_doing(f"reading {item.path}")
    if item.project:
        return load_layers(checked.projects[item.path], mesh_set)
    before = {int(mesh.id()) for mesh in mesh_set}
    load(item.path, mesh_set)
    added = {int(mesh.id()) for mesh in mesh_set} - before
    return dict.fromkeys(sorted(added), item.path)


def identifier_of(mesh_set: Any, output: Output) -> int:
    """Return the identifier of the layer that an output means.

    Raises
    ------
    FileError
        There is no such layer.
    """
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


class _Run:
    """One job that was checked, on one document."""

    def __init__(self, job: Job, checked: Checked, journal: Journal) -> None:
        self.job = job
        self.checked = checked
        self.journal = journal
        self.mesh_set = new_document()
        self.origins: dict[int, Path] = {}  # the file of each layer that was loaded
        self.reports: list[Any] = []
        self.files: list[dict[str, Any]] = []
        self.started = time.perf_counter()

    def all(self) -> int:
        self.dump()
        with native_log(self.mesh_set) as log:
            return self.work(log)

    def work(self, log: Any) -> int:
        for item in self.job.loads:
            self.load(item)
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
        self.origins |= load_item(item, self.checked, self.mesh_set)
        for position, mesh in enumerate(self.mesh_set):
            if mesh.id() not in before:
                size = f"{mesh.vertex_number()} vn {mesh.face_number()} fn"
                self.journal.say(f"{self.origins[mesh.id()]} loaded as layer {position} ({size})")

    def check_layers(self) -> None:
        """Refuse layers that do not exist before anything is written; scripts may make some."""
        for output in self.job.outputs:
            identifier_of(self.mesh_set, output)

    def run_scripts(self, log: Any) -> None:
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
        for identifier in [int(mesh.id()) for mesh in self.mesh_set]:
            bake_layer(self.mesh_set, identifier)

    def save_project(self, number: int) -> bool:
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
            identifier = identifier_of(self.mesh_set, output)
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
        data = {
            "inputs": [str(item.path) for item in self.job.loads],
            "scripts": self.reports,
            "outputs": self.files,
            "notes": list(self.job.notes),
            "seconds": time.perf_counter() - self.started,
            "exit_code": code,
        }
        write_json(self.job.report, data)
