"""The help of ``symrecon-server``."""

from __future__ import annotations

from meshlab_symrecon.cli.server_job import FLAGS

__all__ = ["HELP", "USAGE"]

USAGE = "symrecon-server [-l LOG] -i MESH... [-s SCRIPT.mlx]... -o MESH [-l LAYER] [-m FLAG...]"
HELP = f"""Usage: {USAGE}

Takes the command lines of meshlabserver, and runs our filters beside MeshLab's own.

  -i MESH...        load meshes; the last one loaded is the current layer
  -p PROJECT        load a project (.mlp, .mlb, .aln)
  -s SCRIPT.mlx     run a filter script; all of them run after all loading, in order
  -o MESH           save the current layer after the last script
     -l LAYER       ... or another one: N (position, from 0), c (current), x (last)
     -m FLAG...     ... with these attributes beside coordinates and faces:
{{flags}}
  -w PROJECT.mlp    save a project, and every layer in NAME_out.EXT beside its own file
     -x             ... or in the place of its own file
  -l LOG            append what happens to a file (anywhere but behind -o)
  -d LIST           write every filter with its parameters to a file

An old -om stands anywhere, and holds for every -o.

Beyond meshlabserver:

  --keep-all        save everything that a layer has and its format can hold
  --bake            apply the layers' matrices before saving
  --strict          refuse scripts of which anything must be mapped to today's MeshLab
  --lenient         pass over steps and parameters that cannot be used, and say which
  --dry-run         load and check everything, and do nothing
  --json R.json     also save what became of every step and file
  --list-filters    list all filters
  -h, --help        show this
  -V, --version     show the version

Exit codes: 0 done, 1 an error (one sentence on stderr), 2 wrong usage, 130 interrupted.
""".replace("{flags}", "\n".join(f"                      {k}  {v}" for k, v in FLAGS.items()))
