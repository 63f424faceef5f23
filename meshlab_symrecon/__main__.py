"""``python -m meshlab_symrecon``: the program ``symrecon``."""

from __future__ import annotations

from meshlab_symrecon.cli.start import symrecon

if __name__ == "__main__":
    symrecon()
