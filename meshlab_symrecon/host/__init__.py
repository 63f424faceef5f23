"""The only door to pymeshlab."""

from __future__ import annotations

import os

# Qt prints each step of a filter script on stderr as it is read; we read them all the time.
os.environ.setdefault("QT_LOGGING_RULES", "*.debug=false")
