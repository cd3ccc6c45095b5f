"""A sequence of .vdb files as a coloured mesh in Houdini: File, Blast, Convert VDB, and a wrangle for the colour.

    hython mesh.py 'out/cubism.$F4.vdb' cubism.hip

NOT RUN IN HOUDINI: it was not at hand. The names of nodes and parameters are those of public scripts and of the
documentation, and what calls Houdini is checked against its type stubs (21.0); a name that is wrong ends in an
error that lists the right ones. Quote the pattern: the shell eats $F4.
"""
from __future__ import annotations

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import hou  # noqa: E402
import hfvdb_houdini as hfvdb  # noqa: E402


def build(pattern: str, surface: str = "surface", colour: str = "Cd", velocity: str = "vel") -> hou.OpNode:
    """The object with its network; the last node is shown and rendered."""
    item = hfvdb.create(hfvdb.network("/obj"), "geo", "hfvdb")
    for child in item.children():
        child.destroy()
    load = hfvdb.load(item, pattern)
    found = hfvdb.grids(load)
    hfvdb.need(found, surface, ("level set", "float"))
    # Convert VDB would take each grid for a surface.
    only = hfvdb.create(item, "blast", "only_surface", load)
    hfvdb.put(only, "group", "@name=%s" % surface)
    hfvdb.put(only, "negate", 1)
    mesh = hfvdb.create(item, "convertvdb", "to_mesh", only)
    hfvdb.put(mesh, "conversion", "poly")
    # The second input is the file: its colours stand on the same voxels as the surface.
    lines = ['v@%s = volumesamplev(1, "%s", v@P);' % (own, name)
             for own, name in (("Cd", colour), ("v", velocity)) if found.get(name, ("", ""))[1] == "vec3s"]
    paint = hfvdb.create(item, "attribwrangle", "sample", mesh, load)
    hfvdb.put(paint, "class", "point")
    hfvdb.put(paint, "snippet", "\n".join(lines))
    if not isinstance(paint, hou.SopNode):
        raise RuntimeError("a wrangle is no SOP")
    paint.setDisplayFlag(True)
    paint.setRenderFlag(True)
    item.layoutChildren()
    return item


def main(arguments: list[str]) -> int:
    if len(arguments) != 2:
        print("usage: hython mesh.py 'PATTERN.$F4.vdb' OUT.hip", file=sys.stderr)
        return 2
    build(arguments[0])
    hou.hipFile.save(arguments[1])
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
