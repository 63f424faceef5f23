"""``symrecon``: the group of commands, and the border where errors become exit codes."""

from __future__ import annotations

import click

from meshlab_symrecon import __version__
from meshlab_symrecon.cli.apply import apply
from meshlab_symrecon.cli.batch import batch
from meshlab_symrecon.cli.border import BorderGroup
from meshlab_symrecon.cli.check import check
from meshlab_symrecon.cli.filters import filters
from meshlab_symrecon.cli.reconstruct import reconstruct
from meshlab_symrecon.cli.script import run
from meshlab_symrecon.cli.upgrade import upgrade

__all__ = ["main"]


@click.group("symrecon", cls=BorderGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="symrecon", message="%(prog)s %(version)s")
def main() -> None:
    """Complete statue scans from their own mirror symmetry, and close them.

    Exit codes: 0 done, 1 an error (one sentence on stderr), 2 wrong usage, 130 interrupted.
    """


for command in (reconstruct, apply, run, batch, check, upgrade, filters):
    main.add_command(command)

if __name__ == "__main__":
    main()
