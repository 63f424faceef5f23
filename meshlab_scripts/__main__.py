"""Print where the scripts are: all of them, or those that are named."""

from __future__ import annotations

import sys

from meshlab_symrecon.errors import FileError
from meshlab_symrecon.meshlab_scripts import script_names, script_path


def main(names: list[str]) -> int:
    """Print a path a line; return the exit code."""
    try:
        paths = [script_path(name) for name in names or script_names()]
    except FileError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    sys.stdout.writelines(f"{path}\n" for path in paths)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
