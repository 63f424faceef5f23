"""Still pictures of a reconstruction, for pages without WebGL and for paper."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

from meshlab_symrecon.errors import SymReconError
from meshlab_symrecon.pictures.projection import fit, open_screen
from meshlab_symrecon.pictures.renderer import render
from meshlab_symrecon.pictures.report_scene import ReportScene
from meshlab_symrecon.pictures.scene import (
    Item,
    PointCloud,
    TriangleMesh,
    colours_by_share,
)
from meshlab_symrecon.pictures.viewpoint import disc_radius

__all__ = ["Still", "draw_stills"]

HEIGHT = 640  # pixels
WIDTHS = (360, 900)  # pixels: the narrowest and the widest still


@dataclass(frozen=True, slots=True)
class Still:
    """A picture and what it shows."""

    png: str  # base64
    size: tuple[int, int]
    caption: str


def draw_stills(scene: ReportScene) -> tuple[Still, Still, Still]:
    """Return the scan, the completed cloud with its plane, and the surface, from one viewpoint.

    Large scenes should be thinned out first.

    Raises
    ------
    SymReconError
        matplotlib is missing.
    """
    camera, scan, completed = scene.camera(), scene.scan, scene.completed
    sheets = scene.sheets()[:1]
    everything = [completed, scene.surface, *(sheet.corners for sheet in sheets)]
    seen = np.concatenate(everything) @ camera.axes().T
    spans = np.maximum(np.ptp(seen, axis=0), np.finfo(float).tiny)
    size = (int(np.clip(round(HEIGHT * spans[0] / spans[1]), *WIDTHS)), HEIGHT)
    aimed = fit(camera, np.concatenate(everything), size, margin=0.03)
    screen = open_screen(aimed, everything, *size)
    cloud = PointCloud(
        completed,
        colours_by_share(scene.mirrored.astype(float)),
        radius=disc_radius(screen, completed),
    )
    scenes: list[tuple[Sequence[Item], str]] = [
        ([PointCloud(scan, radius=disc_radius(screen, scan))], "The scan, as it was measured."),
        ([cloud, *sheets], _completed_words(scene)),
        (
            [TriangleMesh(scene.surface, scene.faces, colours_by_share(scene.share))],
            "The reconstructed surface, coloured by the share that was invented.",
        ),
    ]
    first, second, third = (
        Still(_png(render(items, aimed, size)), size, words) for items, words in scenes
    )
    return first, second, third


def _completed_words(scene: ReportScene) -> str:
    if not len(scene.planes):
        return "No mirror plane was found, so no point was invented."
    which = "The best mirror plane" if len(scene.planes) > 1 else "The mirror plane"
    return f"{which}, and the completed points: invented ones are darker and green-blue."


def _png(image: NDArray[np.uint8]) -> str:
    """Return a picture as PNG in base64."""
    try:
        from matplotlib.image import imsave
    except ImportError as error:
        message = (
            f"a report needs matplotlib, which cannot be imported ({error}); "
            'install it with: pip install "meshlab-symrecon[report]"'
        )
        raise SymReconError(message) from error
    stream = BytesIO()
    imsave(stream, image, format="png", metadata={"Software": None})  # type: ignore[dict-item]
    return b64encode(stream.getvalue()).decode("ascii")
