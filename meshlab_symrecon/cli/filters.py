"""``symrecon filters``: what filters there are, and what each declares."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click

__all__ = ["filters"]

WIDTH_IN_A_PIPE = 1000  # columns; nothing is cut off there


@click.command()
@click.argument("name", required=False)
@click.option("--all", "every", is_flag=True, help="List MeshLab's own filters too.")
@click.option("--json", "as_json", is_flag=True, help="Print every declared fact as JSON.")
@click.option(
    "--markdown", is_flag=True, help="Print the docs page of NAME, or the list of all pages."
)
@click.option(
    "--pages",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Write the list to FOLDER/filters.md and each page to FOLDER/filters/.",
)
def filters(
    name: str | None, every: bool, as_json: bool, markdown: bool, pages: Path | None
) -> None:
    """List the filters, or show one by any of its NAMEs."""
    from meshlab_symrecon.host.native_filters import native_filters
    from meshlab_symrecon.host.registration import registry
    from meshlab_symrecon.host.resolution import find_any

    if pages is not None:
        _write_pages(pages, name)
        return
    if markdown:
        click.echo(_markdown(name), nl=False)
        return
    if name is not None:
        item = find_any(name)
        click.echo(_as_json(_facts(item)) if as_json else _page(item))
        return
    listed: list[Any] = [*registry(), *(native_filters().values() if every else ())]
    if as_json:
        click.echo(_as_json([_facts(item) for item in listed]))
    else:
        _print_table(listed)
        if not every:
            count = len(native_filters())
            click.echo(f"and {count} of MeshLab's own; 'symrecon filters --all' lists them")
    for failure in registry().failures:
        click.echo(f"warning: {failure.reason}", err=True)


def _markdown(name: str | None) -> str:
    from meshlab_symrecon.cli.filter_pages import filter_page, index_page
    from meshlab_symrecon.host.registration import find_filter, registry

    return index_page(registry()) if name is None else filter_page(find_filter(name))


def _write_pages(folder: Path, name: str | None) -> None:
    from meshlab_symrecon.cli.filter_pages import write_pages
    from meshlab_symrecon.host.registration import registry

    if name is not None:
        raise click.UsageError("--pages writes the pages of all filters; give no NAME with it")
    for path in write_pages(registry(), folder):
        click.echo(f"written {path}")


def _as_json(data: Any) -> str:
    return json.dumps(data, indent=2, ensure_ascii=False)


def _facts(item: Any) -> dict[str, Any]:
    from meshlab_symrecon.plugin import Filter
    from meshlab_symrecon.plugin.documentation import describe

    if isinstance(item, Filter):
        return describe(item)
    return {
        "menu_name": item.menu_name,
        "python_name": item.python_name,
        "parameters": [
            {
                "id": parameter.name,
                "script_name": parameter.script_name,
                "type": parameter.rich_type,
                "choices": list(parameter.words) or None,
            }
            for parameter in item.parameters
        ],
    }


def _page(item: Any) -> str:
    from meshlab_symrecon.plugin import Filter
    from meshlab_symrecon.plugin.documentation import parameter_lines

    if isinstance(item, Filter):
        names = ", ".join((item.python_name, *item.aliases))
        body = [item.summary, "", item.description, "", *parameter_lines(item)]
        references = [str(citation) for citation in item.citations]
        tail = ["", "References:", *references] if references else []
        return "\n".join([item.menu_name, names, "", *body, *tail])
    lines = [
        f"- `{parameter.name}` : {parameter.rich_type.removeprefix('Rich')}"
        + (
            f", one of {', '.join(repr(word) for word in parameter.words)}"
            if parameter.words
            else ""
        )
        for parameter in item.parameters
    ]
    return "\n".join(
        [item.menu_name, f"{item.python_name} (MeshLab's own)", "", *(lines or ["No parameters."])]
    )


def _print_table(listed: Iterable[Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("Python name", "menu name", "what it does", box=None, pad_edge=False)
    for item in listed:
        summary = getattr(item, "summary", "MeshLab's own")
        table.add_row(item.python_name, item.menu_name, summary)
    width = None if sys.stdout.isatty() else WIDTH_IN_A_PIPE
    Console(width=width, markup=False, highlight=False, file=sys.stdout).print(table)
