"""Docs rendered from a declaration hold every declared fact."""

from __future__ import annotations

import json
from dataclasses import replace

from meshlab_symrecon.plugin import ParameterSet
from meshlab_symrecon.plugin.documentation import (
    describe,
    method_documentation,
    parameter_lines,
    signature,
)


class Nothing(ParameterSet):
    """No parameters."""


def test_signature(grow_filter):
    assert signature(grow_filter) == "generate_grown_points(factor=2.0, about='origin')"


def test_parameter_lines(grow_filter):
    assert parameter_lines(grow_filter) == [
        "- `factor` : a number of at least 0 = 2.0. *Factor*: Points move away from 0 by this.",
        "- `about` : one of 'origin', 'centre' = 'origin'. *About*: What stays where it is.",
    ]


def test_facts_survive_json(grow_filter):
    facts = json.loads(json.dumps(describe(grow_filter)))
    assert facts["aliases"] == ["grow_points"]
    assert facts["references"][0]["issued"] == 2001
    assert facts["parameters"] == [
        {
            "id": "factor",
            "label": "Factor",
            "type": "number",
            "default": 2.0,
            "range": [0.0, None],
            "choices": None,
            "unit": "",
            "help": "Points move away from 0 by this.",
        },
        {
            "id": "about",
            "label": "About",
            "type": "choice",
            "default": "origin",
            "range": [None, None],
            "choices": ["origin", "centre"],
            "unit": "",
            "help": "What stays where it is.",
        },
    ]


def test_docstring_of_the_method(grow_filter):
    assert method_documentation(grow_filter) == (
        "Move points away from the origin.\n\nEvery point is multiplied by a factor.\n\n"
        "Parameters\n----------\n"
        "factor : a number of at least 0, default 2.0\n"
        "    Factor: Points move away from 0 by this.\n"
        "about : one of 'origin', 'centre', default 'origin'\n"
        "    About: What stays where it is.\n"
        "\nReferences\n----------\nA. Author (2001). On growth. Journal. doi:10.1/2\n"
    )
    bare = replace(grow_filter, parameters=Nothing, citations=())
    assert method_documentation(bare).endswith("Every point is multiplied by a factor.\n")
