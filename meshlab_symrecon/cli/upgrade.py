"""``symrecon upgrade``: an old script in today's names, in words, or as a Python program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from meshlab_symrecon.cli.file_path import FilePath

__all__ = ["upgrade"]

EXAMPLES = """
\b
symrecon upgrade old.mlx new.mlx
symrecon upgrade old.mlx --explain
symrecon upgrade old.mlx same.py --to-python
symrecon upgrade old.mlx for_meshlab.mlx --native-only
"""


@click.command(epilog=EXAMPLES)
@click.argument("old", type=FilePath(), metavar="OLD.mlx")
@click.argument("new", required=False, type=FilePath(), metavar="[NEW]")
@click.option("--explain", is_flag=True, help="Say in words what each step does, mistakes too.")
@click.option("--to-python", is_flag=True, help="Write an equivalent program for pymeshlab.")
@click.option(
    "--native-only",
    is_flag=True,
    help="Leave out filters that are not MeshLab's own: its window crashes on them.",
)
@click.option("--lenient", is_flag=True, help="Leave out what cannot run, with a comment.")
def upgrade(
    old: Path, new: Path | None, explain: bool, to_python: bool, native_only: bool, lenient: bool
) -> None:
    """Write an old MeshLab filter script in today's names, with comments on what changed.

    The new script does the same as the old one. It is written to NEW, or to the standard output.
    """
    from meshlab_symrecon.host.findings import check_findings
    from meshlab_symrecon.host.mlx_reading import read_script
    from meshlab_symrecon.host.native_only import for_the_window, without_plugins
    from meshlab_symrecon.host.resolution import matched
    from meshlab_symrecon.host.upgrade import checked

    if explain and to_python:
        raise click.UsageError("--explain and --to-python exclude each other; give one of them")
    _check_new(old, new)
    script = read_script(old)
    matching = matched(script) if explain else checked(script, lenient=lenient)
    found = matching.findings
    if native_only:
        matching = (without_plugins if to_python else for_the_window)(script, matching)
        if not explain:
            check_findings(matching.findings, lenient=lenient)
        for finding in matching.findings:
            if finding not in found:
                click.echo(f"{finding}", err=True)
    content = _content(script, matching, explain, to_python)
    _write(content, new)
    if new is not None:
        for finding in found:
            click.echo(f"{finding}")
        click.echo(f"written {new}")


def _check_new(old: Path, new: Path | None) -> None:
    from meshlab_symrecon.host.paths import check_output

    if new is not None:
        check_output(new, [old], ())


def _content(script: Any, matching: Any, explain: bool, to_python: bool) -> bytes:
    from meshlab_symrecon.host.explanation import explained
    from meshlab_symrecon.host.mlx_writing import script_text
    from meshlab_symrecon.host.python_script import python_script
    from meshlab_symrecon.host.upgrade import upgraded

    if explain:
        return explained(script, matching).encode()
    if to_python:
        return python_script(script, matching).encode()
    result = upgraded(script, matching)
    if result.unchanged and script.path.is_file():  # a pipe is empty by now
        return script.path.read_bytes()
    return script_text(result.steps, script.path, result.comments).encode()


def _write(content: bytes, path: Path | None) -> None:
    from meshlab_symrecon.host.atomic import replacing

    if path is None:
        click.echo(content, nl=False)
        return
    with replacing(path) as staged:
        staged.write_bytes(content)
