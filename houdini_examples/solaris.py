"""A sequence of .vdb files as a Volume in Solaris: a USD layer, and a Sublayer LOP that brings it in.

    hython solaris.py cubism.hip out/cubism.*.vdb

The layer, cubism.usda, stands beside the scene. NOT RUN IN HOUDINI: it was not at hand; see mesh.py. What writes the
layer was run with usd-core. A Karma material reads colours by the name of the field's relationship, `field:Cd`.
"""
from __future__ import annotations

import os
import re
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import hou  # noqa: E402
import hfvdb_houdini as hfvdb  # noqa: E402
import volume_layer  # noqa: E402


def number(path: str) -> int:
    """The frame's number: the last digits before the extension."""
    found = re.search(r"(\d+)\.vdb$", os.path.basename(path))
    if found is None:
        raise RuntimeError("%s: the frame's number has to stand last before .vdb" % path)
    return int(found[1])


def boxes(files: dict[int, str]) -> dict[int, volume_layer.Box]:
    """The box of each file's grids."""
    found: dict[int, volume_layer.Box] = {}
    for frame, path in files.items():
        geometry = hou.Geometry()
        geometry.loadFromFile(path)
        box = geometry.boundingBox()
        low, high = box.minvec(), box.maxvec()
        found[frame] = (low[0], low[1], low[2]), (high[0], high[1], high[2])
    return found


def build(layer: str, paths: list[str]) -> hou.OpNode:
    """Writes the layer, and returns the LOP."""
    files = {number(path): path for path in paths}
    # What the first file holds, all have.
    probe = hfvdb.create(hfvdb.network("/obj"), "geo", "hfvdb_probe")
    grids = hfvdb.grids(hfvdb.load(probe, files[min(files)]))
    probe.destroy()
    volume_layer.write(layer, files, boxes(files), grids, hou.fps())
    node = hfvdb.create(hfvdb.network("/stage"), "sublayer", "hfvdb")
    hfvdb.put(node, "filepath1", layer)
    return node


def main(arguments: list[str]) -> int:
    if len(arguments) < 2:
        print("usage: hython solaris.py OUT.hip FILE.vdb [FILE.vdb ...]", file=sys.stderr)
        return 2
    build(os.path.splitext(os.path.abspath(arguments[0]))[0] + ".usda", arguments[1:])
    hou.hipFile.save(arguments[0])
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
