"""The docs of filters, rendered from their declarations: lines, docstrings, facts for JSON."""

from __future__ import annotations

from typing import Any

from meshlab_symrecon.plugin.filter import Filter
from meshlab_symrecon.plugin.parameters import Kind, Parameter

__all__ = ["describe", "method_documentation", "parameter_lines", "signature"]


def signature(item: Filter) -> str:
    """Return the Python call with every parameter and default."""
    arguments = ", ".join(
        f"{parameter.name}={parameter.default!r}" for parameter in item.parameters.declared()
    )
    return f"{item.python_name}({arguments})"


def parameter_lines(item: Filter) -> list[str]:
    """Return one Markdown line for each parameter."""
    return [_parameter_line(parameter) for parameter in item.parameters.declared()]


def _parameter_line(parameter: Parameter) -> str:
    default = parameter.default
    shown = f"'{default}'" if isinstance(default, str) else f"{default}"
    return (
        f"- `{parameter.name}` : {parameter.range_words} = {shown}. "
        f"*{parameter.label}*: {parameter.tooltip}"
    )


def describe(item: Filter) -> dict[str, Any]:
    """Return every declared fact of a filter as plain data for JSON."""
    return {
        "menu_name": item.menu_name,
        "python_name": item.python_name,
        "aliases": list(item.aliases),
        "summary": item.summary,
        "description": item.description,
        "meshlab_class": item.meshlab_class,
        "category": item.category,
        "arity": item.arity,
        "requires": list(item.requires),
        "creates": list(item.creates),
        "references": [
            {
                "author": citation.authors,
                "title": citation.title,
                "container-title": citation.container,
                "issued": citation.year,
                "DOI": citation.identifier,
            }
            for citation in item.citations
        ],
        "parameters": [_parameter_facts(parameter) for parameter in item.parameters.declared()],
    }


def _parameter_facts(parameter: Parameter) -> dict[str, Any]:
    return {
        "id": parameter.name,
        "label": parameter.label,
        "type": parameter.kind.name.lower(),
        "default": parameter.default,
        "range": [parameter.low, parameter.high],
        "choices": list(parameter.choices) if parameter.kind is Kind.CHOICE else None,
        "unit": parameter.unit,
        "help": parameter.tooltip,
    }


def method_documentation(item: Filter) -> str:
    """Return the docstring of the filter's method of ``MeshSet``, in numpy style."""
    lines = [item.summary, "", item.description, ""]
    if item.parameters.declared():
        lines += ["Parameters", "----------"]
    for parameter in item.parameters.declared():
        lines.append(f"{parameter.name} : {parameter.range_words}, default {parameter.default!r}")
        lines.append(f"    {parameter.label}: {parameter.tooltip}")
    if item.citations:
        lines += ["", "References", "----------", *(str(citation) for citation in item.citations)]
    return "\n".join(lines).rstrip() + "\n"
