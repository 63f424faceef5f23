"""MeshLab's own filters: found by every one of their names, checked, and run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files
from typing import Any

from meshlab_symrecon.host.translation import translated
from meshlab_symrecon.plugin.registry import plain_name
