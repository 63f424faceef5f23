"""Filter scripts on a MeshSet: everything is checked first, then the steps run one by one.

pymeshlab's own runner passes over what it does not know, cuts floats down to six digits and may
end the process; nothing of it is used here.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from meshlab_symrecon.errors import ScriptError, SymReconError
from meshlab_symrecon.host.checking import check_document
from meshlab_symrecon.host.document_state import DocumentState
from meshlab_symrecon.host.findings import ERROR, REMARK, SKIP, Finding, check_findings, place
from meshlab_symrecon.host.mlx import Script, Step
from meshlab_symrecon.host.mlx_reading import read_script
from meshlab_symrecon.host.resolution import ResolvedStep, matched
from meshlab_symrecon.host.step_running import Ran, run_resolved
from meshlab_symrecon.plugin import Progress
from meshlab_symrecon.plugin.filter import silent

__all__ = ["ScriptReport", "StepReport", "checked_script", "run_script", "run_steps"]

RAN, MAPPED, SKIPPED = "ran", "mapped", "skipped"


@dataclass(frozen=True, slots=True)
class StepReport:
    """What became of one step.

    Attributes
    ----------
    file, line : str, int
        Where it is written.
    name : str
        As it was written.
    filter : str
        Python name of the filter it became; empty when it became none.
    status : str
        ``ran``; ``mapped`` when it ran otherwise than it was written; ``skipped`` when it did not
        run, which only a lenient run allows.
    notes : tuple of str
        What was mapped or ignored and why, why it was skipped, and what the filter warned of.
    seconds : float
    measures : mapping
        What the filter returned.
    parameters : mapping
        All that it ran with, by Python names, as plain data; empty when nothing ran.
    then : mapping
        ``filter`` and ``parameters`` of the one that ran after it, for what an old parameter did;
        empty for most.
    """

    file: str
    line: int
    name: str
    filter: str
    status: str
    notes: tuple[str, ...] = ()
    seconds: float = 0.0
    measures: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    then: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ScriptReport:
    """What became of a script."""

    script: str
    steps: tuple[StepReport, ...]
    seconds: float


def run_script(
    mesh_set: Any,
    path: str | Path,
    *,
    strict: bool = False,
    lenient: bool = False,
    progress: Progress | None = None,
) -> ScriptReport:
    """Read a whole script, check it, then run it step by step.

    Parameters
    ----------
    mesh_set : pymeshlab.MeshSet
    path : str or Path
        Numbers of layers in it are positions, counted from 0 when the step runs.
    strict : bool
        Refuse a script of which anything would be mapped or ignored.
    lenient : bool
        Pass over steps that cannot run and parameters that cannot be used, and report each.
    progress : callable, optional
        Called with a fraction 0..1 of the whole script, and a message.

    Raises
    ------
    FileError
        The script cannot be read.
    ScriptError
        It has mistakes, all of which are listed and nothing has run; or a step failed, after which
        the later ones do not run.
    """
    return run_steps(mesh_set, read_script(path), strict=strict, lenient=lenient, progress=progress)


def checked_script(path: str | Path, *, strict: bool = False, lenient: bool = False) -> Script:
    """Read a script and check all that can be checked without a document.

    Raises
    ------
    FileError, ScriptError
        As ``run_script``.
    """
    script = read_script(path)
    check_findings(matched(script).findings, strict=strict, lenient=lenient)
    return script


def run_steps(
    mesh_set: Any,
    script: Script,
    *,
    strict: bool = False,
    lenient: bool = False,
    progress: Progress | None = None,
) -> ScriptReport:
    """Check a script that has been read, then run it step by step; see ``run_script``."""
    report = progress or silent
    started = time.perf_counter()
    matching = matched(script)
    check_findings(matching.findings, strict=strict, lenient=lenient)
    expected = check_document(matching.steps, DocumentState.of(mesh_set), script.path)
    check_findings(expected, lenient=lenient)
    runner = _Runner(mesh_set, script, (*matching.findings, *expected), lenient)
    reports = []
    pairs = zip(script.steps, matching.steps, strict=True)
    for number, (step, resolved) in enumerate(pairs):
        name = f"{place(str(script.path), step.line, number)}: '{step.name.strip()}'"
        share = _share(report, number, len(script.steps), name)
        share(0.0, "")
        reports.append(runner.run(number, resolved, share))
    report(1.0, "done")
    return ScriptReport(str(script.path), tuple(reports), time.perf_counter() - started)


def _share(progress: Progress, number: int, count: int, name: str) -> Progress:
    """Return the progress of one step as a part of the whole, under the step's name."""

    def share(fraction: float, message: str) -> None:
        progress((number + fraction) / count, f"{name}, {message}" if message else name)

    return share


@dataclass(frozen=True, slots=True)
class _Runner:
    """Runs the steps of one script on one document."""

    mesh_set: Any
    script: Script
    findings: Sequence[Finding]
    lenient: bool
    meshes: set[int] = field(default_factory=set)  # layers that have, or had, faces

    def run(self, number: int, resolved: ResolvedStep | None, progress: Progress) -> StepReport:
        step = self.script.steps[number]
        found = [finding for finding in self.findings if finding.step == number]
        self.meshes.update(int(mesh.id()) for mesh in self.mesh_set if mesh.face_number())
        started = time.perf_counter()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            status, ran, failure = self._attempted(number, resolved, found, progress)
        for warning in caught:
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )
        notes = [_in_words(finding, step) for finding in found]
        notes += [*failure, *(str(warning.message) for warning in caught)]
        return StepReport(
            str(self.script.path), step.line, step.name,
            "" if resolved is None else resolved.python_name, status, tuple(notes),
            time.perf_counter() - started, ran.measures, ran.parameters, ran.then,
        )  # fmt: skip

    def _attempted(
        self,
        number: int,
        resolved: ResolvedStep | None,
        found: Sequence[Finding],
        progress: Progress,
    ) -> tuple[str, Ran, list[str]]:
        """Run a step; return what became of it, what ran, and why it failed."""
        if resolved is None or any(finding.remedy == SKIP for finding in found):
            return SKIPPED, Ran(), []
        try:
            ran = run_resolved(self.mesh_set, resolved, self.meshes, progress)
        except SymReconError as error:
            words = _named(resolved.step, error)
            if not self.lenient:
                where = place(str(self.script.path), resolved.step.line, number)
                raise ScriptError(f"{where}: {words}") from error
            return SKIPPED, Ran(), [words]
        mapped = any(finding.severity != REMARK for finding in found)
        return MAPPED if mapped else RAN, ran, []


def _in_words(finding: Finding, step: Step) -> str:
    """Return a finding as a note of its step, with the line when it is not the step's own."""
    words = finding.message
    if finding.severity == ERROR:
        words = f"{words}; {'skipped' if finding.remedy == SKIP else 'ignored'}"
    return words if finding.line == step.line else f"line {finding.line}: {words}"


def _named(step: Step, error: SymReconError) -> str:
    """Return the error's words, with the name of the step unless they have it."""
    words = str(error)
    return words if step.name.strip() in words else f"'{step.name.strip()}': {words}"
