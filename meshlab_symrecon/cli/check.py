"""``symrecon check``: everything that is wrong with a script, before anything runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from meshlab_symrecon.cli.border import DONE, FAILED
from meshlab_symrecon.cli.file_path import FilePath

if TYPE_CHECKING:
    from meshlab_symrecon.host.document_state import DocumentState
    from meshlab_symrecon.host.findings import Finding

__all__ = ["check"]

PASSED_OVER = {"skip": "skipped", "ignore": "ignored"}  # what a lenient run does about an error


@click.command()
@click.argument("script", type=FilePath(), metavar="SCRIPT.mlx")
@click.argument("inputs", nargs=-1, type=FilePath(), metavar="[IN]...")
@click.option("--strict", is_flag=True, help="What would be mapped or ignored counts as an error.")
@click.option("--lenient", is_flag=True, help="Errors that a lenient run passes over do not count.")
@click.option(
    "--json", "report", type=FilePath(), metavar="R.json",
    help="Also save what was found.",
)  # fmt: skip
def check(
    script: Path, inputs: tuple[Path, ...], strict: bool, lenient: bool, report: Path | None
) -> int:
    """Say all that is wrong with a MeshLab filter script, one finding a line; run nothing.

    With the meshes or projects IN... that it is meant for, each step is also checked against what
    the layers will be then: layers that will not exist, clouds that a step would empty, missing
    faces, colours or textures. Exits with 0 when the script can run, else with 1.
    """
    from meshlab_symrecon.cli.reports import write_json
    from meshlab_symrecon.errors import ScriptError
    from meshlab_symrecon.host.checking import check_script
    from meshlab_symrecon.host.mlx_reading import read_script
    from meshlab_symrecon.host.paths import check_output
    from meshlab_symrecon.host.projects import files_of

    if strict and lenient:
        raise click.UsageError("--strict and --lenient contradict each other; give one")
    if report is not None:
        kept = [file for path in inputs for file in files_of(path)]
        check_output(report, [script, *kept], ())
    try:
        written = read_script(script)
    except ScriptError as error:
        if report is not None:
            write_json(report, _report(script, inputs, [(_unreadable(script, error), "error")]))
        raise
    findings = check_script(written, _state(inputs))
    shown = [(finding, _verdict(finding, strict, lenient)) for finding in findings]
    failed = any(verdict == "error" for _, verdict in shown)
    if report is not None:
        write_json(report, _report(script, inputs, shown))
    for finding, verdict in shown:
        click.echo(f"{finding.file}:{finding.line}: {verdict}: {finding.message}")
    click.echo(_summary(len(written.steps), [verdict for _, verdict in shown]))
    return FAILED if failed else DONE


def _unreadable(script: Path, error: Exception) -> Finding:
    """Return the finding that an error of reading a script is, which begins with its place."""
    from meshlab_symrecon.host.findings import Finding

    line, _, words = str(error).removeprefix(f"{script}:").partition(": ")
    return Finding(str(script), int(line), words)


def _report(
    script: Path, inputs: tuple[Path, ...], shown: list[tuple[Finding, str]]
) -> dict[str, object]:
    return {
        "script": str(script),
        "inputs": [str(path) for path in inputs],
        "runs": all(verdict != "error" for _, verdict in shown),
        "findings": [_facts(finding, verdict) for finding, verdict in shown],
    }


def _state(inputs: tuple[Path, ...]) -> DocumentState:
    """Return what is known of the document that a script will work on."""
    from meshlab_symrecon.host.document_state import DocumentState
    from meshlab_symrecon.host.files import new_document
    from meshlab_symrecon.host.projects import load_input

    if not inputs:
        return DocumentState.unknown()
    mesh_set = new_document()
    for path in inputs:
        load_input(path, mesh_set)
    return DocumentState.of(mesh_set)


def _verdict(finding: Finding, strict: bool, lenient: bool) -> str:
    if finding.severity != "error":
        return "error" if strict and finding.severity == "note" else "note"
    return PASSED_OVER.get(finding.remedy, "error") if lenient else "error"


def _facts(finding: Finding, verdict: str) -> dict[str, object]:
    return {
        "file": finding.file,
        "line": finding.line,
        "step": finding.step,
        "verdict": verdict,
        "severity": finding.severity,
        "remedy": finding.remedy,
        "message": finding.message,
    }


def _summary(steps: int, verdicts: list[str]) -> str:
    """Return a line such as ``3 steps, 1 error, 2 notes: it cannot run``."""
    kinds = [(verdicts.count(kind), kind) for kind in ("error", "skipped", "ignored", "note")]
    counts = [_counted(steps, "step")]
    counts += [
        _counted(count, kind) if kind in ("error", "note") else f"{count} {kind}"
        for count, kind in kinds
        if count
    ]
    return f"{', '.join(counts)}: it {'cannot' if kinds[0][0] else 'can'} run"


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"
