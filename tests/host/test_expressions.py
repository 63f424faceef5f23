"""Expressions of old scripts mean the same today."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from meshlab_symrecon.host.expressions import modern_expression


@pytest.mark.parametrize(
    ("old", "today"),
    [
        ("(x>0) and (y>0)", "(x>0) && (y>0)"),
        ("x>0 OR y>0", "x>0 || y>0"),
        ("if(x>0, 1, 0)", "((x>0) ? (1) : (0))"),
        ("2*if (x>0,max(x,y),-x)+1", "2*((x>0) ? (max(x,y)) : (-x))+1"),
        ("if(x<1, if(x>-1, x, -1), 1)", "((x<1) ? (((x>-1) ? (x) : (-1))) : (1))"),
        ("x > 0 ? y : z", "x > 0 ? y : z"),
        ("radius + floor(z) - diff", "radius + floor(z) - diff"),
        ("sand + order + iff", "sand + order + iff"),
        ("if(x,1)", "if(x,1)"),
        ("if(x,1,0", "if(x,1,0"),
        ("", ""),
    ],
)
def test_old_words_become_those_of_today(old, today):
    assert modern_expression(old) == today
    assert modern_expression(today) == today


def test_meshlab_takes_what_comes_out():
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.create_sphere(subdiv=2)
    x, y, z = mesh_set.current_mesh().vertex_matrix().T
    for old, expected in (
        ("(x>0.1) and ((y>0) or (z>0.2))", (x > 0.1) & ((y > 0) | (z > 0.2))),
        ("if(x>0.1, if(y>0, 1, 0), z>0.2)", np.where(x > 0.1, y > 0, z > 0.2)),
    ):
        mesh_set.compute_selection_by_condition_per_vertex(condselect=modern_expression(old))
        selected = mesh_set.current_mesh().vertex_selection_array()
        assert 0 < selected.sum() < len(x)
        np.testing.assert_array_equal(selected, expected)
