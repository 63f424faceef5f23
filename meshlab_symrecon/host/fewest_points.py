"""To how few points a scan may be thinned out: told to options before anything heavy is loaded."""

from __future__ import annotations

__all__ = ["FEWEST_POINTS"]

FEWEST_POINTS = 100  # with fewer no statue is to be recognised
