"""``symrecon``: the group of commands, and the border where errors become exit codes."""

from __future__ import annotations

from typing import Any

import click

from meshlab_symrecon import __version__
from meshlab_symrecon.cli.apply import apply
from meshlab_symrecon.cli.batch import batch
from meshlab_symrecon.cli.border import BorderGroup
from meshlab_symrecon.cli.check import check
from meshlab_symrecon.cli.filters import filters
from meshlab_symrecon.cli.long_work import long_options
from meshlab_symrecon.cli.reconstruct import reconstruct
from meshlab_symrecon.cli.script import run
from meshlab_symrecon.cli.threads import limited_threads
from meshlab_symrecon.cli.upgrade import upgrade

__all__ = ["main"]

BATCH_GRACE = 8.0  # seconds to end its processes after Ctrl-C


@click.group("symrecon", cls=BorderGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(
    __version__, "-V", "--version", prog_name="symrecon", message="%(prog)s %(version)s"
)
@click.pass_context
def main(context: click.Context, /, threads: int | None, **of_commands: Any) -> None:
    """Complete statue scans from their own mirror symmetry, and close them.

    --quiet, --log and --threads are for the commands that work on scans, before or after their
    name.

    Exit codes: 0 done, 1 an error (one sentence on stderr), 2 wrong usage, 130 interrupted (143 by
    SIGTERM, 129 by SIGHUP).
    """
    from meshlab_symrecon.host.interruption import unhurried

    context.with_resource(limited_threads(threads))
    if context.invoked_subcommand == batch.name:
        context.with_resource(unhurried(BATCH_GRACE))


main.params += long_options()
for command in (reconstruct, apply, run, batch, check, upgrade, filters):
    main.add_command(command)

if __name__ == "__main__":
    main()
