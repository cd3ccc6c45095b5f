"""A sequence of .vdb files as a Volume in Solaris: a Sublayer LOP that brings in the layer that hfvdb wrote.

    hfvdb usd 'out/cubism.####.vdb' -o cubism.usda
    hython solaris.py cubism.hip cubism.usda

NOT RUN IN HOUDINI: it was not at hand; see mesh.py. The layer itself is read by USD's library in the tests. A Karma
material reads colours by the name of the field's relationship, `field:Cd`.
"""
from __future__ import annotations

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import hou  # noqa: E402
import hfvdb_houdini as hfvdb  # noqa: E402


def build(layer: str) -> hou.OpNode:
    """Brings a layer into the stage, and returns the LOP."""
    node = hfvdb.create(hfvdb.network("/stage"), "sublayer", "hfvdb")
    hfvdb.put(node, "filepath1", os.path.abspath(layer))
    return node


def main(arguments: list[str]) -> int:
    if len(arguments) != 2:
        print("usage: hython solaris.py OUT.hip LAYER.usda", file=sys.stderr)
        return 2
    build(arguments[1])
    hou.hipFile.save(arguments[0])
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
