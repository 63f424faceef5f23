"""What the tests of batches work on."""

from __future__ import annotations

import numpy as np

from meshlab_symrecon.batch import Listener

SCRIPT = """<FilterScript>
 <filter name="Be Awkward"/>
 <filter name="Transform: Scale, Normalize">
  <Param type="RichFloat" name="axisX" value="0.5"/>
 </filter>
</FilterScript>
"""


def cloud(path, count, seed=0):
    """Write an ASCII PLY of points on a sphere."""
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    rows = "\n".join(" ".join(map(repr, row)) for row in points.tolist())
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        f"ply\nformat ascii 1.0\nelement vertex {count}\nproperty double x\n"
        f"property double y\nproperty double z\nend_header\n{rows}\n"
    )
    return path


class Witness(Listener):
    """Remember all that is told."""

    def __init__(self):
        self.total, self.reports, self.sentences = 0, [], []

    def planned(self, total):
        self.total = total

    def ended(self, report):
        self.reports.append(report)

    def said(self, sentence):
        self.sentences.append(sentence)
