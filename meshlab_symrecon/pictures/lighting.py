"""Light and shade: a key light with soft shadows, a fill light and the light of the sky."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.arrays import Booleans, Floats

__all__ = ["KEY", "shade"]

KEY = np.array([-0.50, 0.62, 0.60])  # from above the viewer's left shoulder
KEY = KEY / np.linalg.norm(KEY)
FILL = np.array([0.80, 0.05, 0.60])  # from the right, weaker
FILL = FILL / np.linalg.norm(FILL)
KEY_POWER, FILL_POWER, SKY_POWER, GROUND_POWER = 0.92, 0.16, 0.32, 0.12
INSIDE = 0.35  # of the light reaches the back of a surface, so that a hole looks like one


def shade(normal: Floats, sky: Floats, key: Floats, inside: Booleans) -> Floats:
    """Return the light that every pixel throws back, as a multiple of its albedo.

    Parameters
    ----------
    normal : (..., 3) float
        Unit normals in the camera's frame (right, up, towards the viewer).
    sky : (...) float
        Share of the sky that is seen, from `occlusion.ambient_light`.
    key : (...) float
        Share of the key light that is not in shadow.
    inside : (...) bool
        The back of the surface is seen.
    """
    direct = KEY_POWER * key * np.clip(normal @ KEY, 0.0, None)
    direct += FILL_POWER * sky * np.clip(normal @ FILL, 0.0, None)
    upward = 0.5 + 0.5 * normal[..., 1]
    ambient = sky * (GROUND_POWER + (SKY_POWER - GROUND_POWER) * upward)
    light: Floats = (direct + ambient) * np.where(inside, INSIDE, 1.0)
    return light
