"""The only door to pymeshlab."""

from __future__ import annotations

import os

# Qt prints each step of a filter script on stderr as it is read; we read them all the time.
os.environ.setdefault("QT_LOGGING_RULES", "*.debug=false")
# MeshLab's threads would spin while they wait for each other: on a busy machine Screened Poisson
# then takes up to ten times the time. It counts only when pymeshlab is first imported after this.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
