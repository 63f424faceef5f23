"""Expressions of old scripts, in the language of today's function and condition filters.

MeshLab's expressions are those of the muParser library. Up to MeshLab 1.3.4 that was version 1,
which wrote ``and``, ``or`` and ``if(condition, then, otherwise)``; version 2, in every MeshLab
since, writes ``&&``, ``||`` and ``condition ? then : otherwise``, and refuses the old words.
"""

from __future__ import annotations

import re

__all__ = ["modern_expression"]

OPERATORS = {"and": "&&", "or": "||"}
OLD_OPERATOR = re.compile(r"\b(and|or)\b", re.IGNORECASE)
OLD_CHOICE = re.compile(r"\bif\s*\(", re.IGNORECASE)


def modern_expression(text: str) -> str:
    """Return an expression that means the same to muParser 2; one of today comes back unchanged.

    A choice whose brackets or commas do not match comes back as it is: MeshLab tells what is wrong.
    """
    text = OLD_OPERATOR.sub(lambda word: OPERATORS[word.group().lower()], text)
    place = 0
    while (choice := OLD_CHOICE.search(text, place)) is not None:
        parts, end = _arguments(text, choice.end())
        if len(parts) != 3:
            place = choice.end()
            continue
        condition, then, otherwise = (part.strip() for part in parts)
        text = f"{text[: choice.start()]}(({condition}) ? ({then}) : ({otherwise})){text[end:]}"
        place = choice.start()  # a choice may hold another one
    return text


def _arguments(text: str, start: int) -> tuple[list[str], int]:
    """Return what stands between commas from ``start`` to the closing bracket, and its end."""
    parts: list[str] = []
    depth, before = 0, start
    for position in range(start, len(text)):
        sign = text[position]
        if sign == ")" and depth == 0:
            return [*parts, text[before:position]], position + 1
        depth += (sign == "(") - (sign == ")")
        if sign == "," and depth == 0:
            parts.append(text[before:position])
            before = position + 1
    return [], start
