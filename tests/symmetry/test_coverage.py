import numpy as np
import pytest

from meshlab_symrecon.symmetry.coverage import covered

UP = np.array([[0.0, 0.0, 1.0]])


def hovers(offset, facing=1.0, *, outward=True):
    found = covered(
        np.array([offset]), UP, np.array([facing]), np.array([0.01]), 1.0, outward=outward
    )
    return bool(found[0])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_straight_above_or_below_is_covered_up_to_the_hover(sign):
    assert hovers([0.0, 0.0, 0.029 * sign])
    assert not hovers([0.0, 0.0, 0.031 * sign])


def test_off_to_the_side_is_beyond_the_rim():
    assert not hovers([0.02, 0.0, 0.001])
    assert hovers([0.009, 0.0, 0.0])
    assert hovers([0.0095, 0.0, 0.028])
    assert not hovers([0.0115, 0.0, 0.028])


def test_a_surface_that_faces_away_covers_nothing():
    assert not hovers([0.0, 0.0, 0.02], facing=-1.0)
    assert not hovers([0.0, 0.0, 0.02], facing=0.4)


def test_without_outward_normals_the_hover_is_lower_and_either_side_counts():
    assert hovers([0.0, 0.0, 0.014], facing=-1.0, outward=False)
    assert not hovers([0.0, 0.0, 0.016], outward=False)
