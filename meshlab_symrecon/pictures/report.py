"""A reconstruction as one web page that needs nothing else: a view, words, numbers, the recipe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from string import Template

from meshlab_symrecon.one_thread import in_one_thread
from meshlab_symrecon.pictures.deviation_colours import STOPS, UNKNOWN, UNSIGNED_STOPS
from meshlab_symrecon.pictures.report_scene import ReportScene, thinned
from meshlab_symrecon.pictures.report_stills import Still, draw_stills
from meshlab_symrecon.pictures.report_traces import plotly_script
from meshlab_symrecon.pictures.report_view import DrawnLayer, View, draw_view
from meshlab_symrecon.pictures.scene import INVENTED, MEASURED, PLANE

__all__ = ["Listing", "ReportWords", "Section", "Table", "report_page"]

FOLDER = "meshlab_symrecon.pictures"


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of words; the first column says what a row is about."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class Listing:
    """Something to copy: a command, a script."""

    text: str


@dataclass(frozen=True, slots=True)
class Section:
    """A heading with paragraphs, tables and listings under it; a smaller heading is a part."""

    heading: str
    content: tuple[str | Table | Listing, ...]
    part: bool = False


@dataclass(frozen=True, slots=True)
class ReportWords:
    """What a report says, in plain text."""

    title: str
    summary: tuple[str, ...]
    warnings: tuple[str, ...]
    sections: tuple[Section, ...]
    footer: str


@in_one_thread
def report_page(scene: ReportScene, words: ReportWords) -> str:
    """Return a reconstruction as an HTML page that loads nothing from anywhere.

    Equal arguments give equal pages. The size is bounded: of large clouds and surfaces the view
    shows a subset.

    Raises
    ------
    SymReconError
        plotly or matplotlib is missing.
    """
    drawn = thinned(scene)
    view = draw_view(drawn)
    folder = files(FOLDER)
    template = Template(folder.joinpath("report_page.html").read_text(encoding="utf-8"))
    return template.substitute(
        title=escape(f"{words.title}: report of a reconstruction"),
        heading=escape(words.title),
        summary="\n".join(f"<p>{escape(sentence)}</p>" for sentence in words.summary),
        warnings=_warnings(words.warnings),
        view_words=escape(_view_words(view, words.title)),
        view_note=escape(_view_note(view, drawn, scene)),
        switches="\n".join(_switch(layer) for layer in view.layers),
        stills="\n".join(_still(still) for still in draw_stills(drawn)),
        legend="\n".join(_legend(view, scene)),
        sections="\n".join(_section(section) for section in words.sections),
        footer=escape(words.footer),
        style=folder.joinpath("report_page.css").read_text(encoding="utf-8"),
        script=folder.joinpath("report_page.js").read_text(encoding="utf-8"),
        plotly=plotly_script(),
        figure=view.figure,
        start=view.start,
    )


def _warnings(sentences: Sequence[str]) -> str:
    if not sentences:
        return ""
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    return f'<ul class="warnings" aria-label="Warnings">{items}</ul>'


def _view_words(view: View, title: str) -> str:
    shown = ", ".join(layer.words.lower() for layer in view.layers)
    return f"Interactive view of {title}, seen from the side with missing parts: {shown}."


def _view_note(view: View, drawn: ReportScene, scene: ReportScene) -> str:
    """Say what the view leaves out, and where it puts the object."""
    parts = (
        (len(drawn.scan), len(scene.scan), "measured points"),
        (int(drawn.mirrored.sum()), int(scene.mirrored.sum()), "invented points"),
        (len(drawn.faces), len(scene.faces), "triangles"),
    )
    less = [f"{some:,} of {all_:,} {what}" for some, all_, what in parts if some < all_]
    note = f"To stay light, the view shows {_listed(less)}. " if less else ""
    origin = ", ".join(f"{number:.7g}" for number in view.frame.origin)
    about = f"about the point ({origin}) of the file"
    return f"{note}It is turned so that the mirror plane stands upright, {about}."


def _listed(items: Sequence[str]) -> str:
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)


def _switch(layer: DrawnLayer) -> str:
    checked = " checked" if layer.visible else ""
    return (
        f'<label><input type="checkbox" id="show-{layer.name}" data-traces="{list(layer.traces)}" '
        f'autocomplete="off"{checked}>{_swatch(layer.colours)}{escape(layer.words)}</label>'
    )


def _swatch(colours: Sequence[tuple[int, int, int]], kind: str = "") -> str:
    stops = ["#{:02x}{:02x}{:02x}".format(*colour) for colour in colours]
    paint = stops[0] if len(stops) == 1 else f"linear-gradient(90deg,{','.join(stops)})"
    return f'<span class="swatch{kind}" style="background:{paint}" aria-hidden="true"></span>'


def _legend(view: View, scene: ReportScene) -> list[str]:
    entries = [_swatch([MEASURED]) + "measured: points of the scan, and surface made from them"]
    if scene.mirrored.any():
        entries.append(_swatch([INVENTED]) + "invented: mirror images, and surface made from them")
        entries.append(_swatch([MEASURED, INVENTED], " bar") + "surface between the two")
    if len(scene.planes):
        entries.append(_swatch([PLANE]) + "mirror plane")
    if view.deviation_span > 0.0:
        span = f"{view.deviation_span:.3g}"
        signed = f"from -{span} (inside) to +{span} (outside)"
        reach = signed if scene.signed else f"from 0 to {span}, inside or outside"
        words = escape(f"deviation {reach}, in the file's unit")
        stops = STOPS if scene.signed else UNSIGNED_STOPS
        entries.append(_swatch([colour for _, colour in stops], " bar") + words)
        entries.append(_swatch([UNKNOWN]) + "nothing to compare with on the other side")
    return [f"<li>{entry}</li>" for entry in entries]


def _still(still: Still) -> str:
    caption = escape(still.caption)
    return (
        f'<figure><img src="data:image/png;base64,{still.png}" width="{still.size[0]}" '
        f'height="{still.size[1]}" alt="{caption}"><figcaption>{caption}</figcaption></figure>'
    )


def _section(section: Section) -> str:
    level = "h3" if section.part else "h2"
    parts = [f"<{level}>{escape(section.heading)}</{level}>"]
    for item in section.content:
        if isinstance(item, Table):
            parts.append(_table(item, section.heading))
        elif isinstance(item, Listing):
            parts.append(f'<pre tabindex="0"><code>{escape(item.text)}</code></pre>')
        else:
            parts.append(f"<p>{escape(item)}</p>")
    return "\n".join(parts)


def _table(table: Table, name: str) -> str:
    head = "".join(f'<th scope="col">{escape(word)}</th>' for word in table.columns)
    rows = []
    for first, *others in table.rows:
        cells = "".join(f"<td>{escape(word)}</td>" for word in others)
        rows.append(f'<tr><th scope="row">{escape(first)}</th>{cells}</tr>')
    return (
        f'<div class="table"><table aria-label="{escape(name)}"><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div>"
    )
