"""What the examples share: nodes whose parameters are asked for by name, and what a file holds.

mypy checks the `hou` API only. Names of nodes, parameters and menu entries are plain strings to it, so each goes
through `create` and `put`, which say what there is where a name is not.
"""
from __future__ import annotations

from typing import Union

import hou

Value = Union[int, float, str]


def put(node: hou.OpNode, name: str, value: Value) -> None:
    """Sets a parameter; an error that lists the node's own where there is none of this name."""
    parameter = node.parm(name)
    if parameter is None:
        there = ", ".join(sorted(parameter.name() for parameter in node.parms()))
        raise RuntimeError("%s has no parameter '%s'; it has: %s" % (node.type().name(), name, there))
    parameter.set(value)


def network(path: str) -> hou.OpNode:
    """A network that every scene has, such as /obj."""
    found = hou.node(path)
    if not isinstance(found, hou.OpNode):
        raise RuntimeError("there is no network %s" % path)
    return found


def create(parent: hou.OpNode, kind: str, name: str, *inputs: hou.OpNode) -> hou.OpNode:
    """A node with its inputs."""
    node = parent.createNode(kind, name)
    for place, source in enumerate(inputs):
        node.setInput(place, source)
    return node


def load(parent: hou.OpNode, path: str) -> hou.OpNode:
    """A File SOP on a pattern such as m.$F4.vdb. A frame that is missing is an error, not an empty one."""
    node = create(parent, "file", "load")
    put(node, "file", path)
    put(node, "missingframe", "error")
    return node


def grids(node: hou.OpNode) -> dict[str, tuple[str, str]]:
    """Class and type of the grids that a SOP gives, by name."""
    if not isinstance(node, hou.SopNode):
        raise RuntimeError("%s is no SOP" % node.path())
    geometry = node.geometry()
    if geometry is None:
        raise RuntimeError("the file did not load: %s" % (node.errors(),))
    found: dict[str, tuple[str, str]] = {}
    for primitive in geometry.prims():
        if isinstance(primitive, hou.VDB):
            kind = primitive.intrinsicValue("vdb_class"), primitive.intrinsicValue("vdb_value_type")
            found[primitive.stringAttribValue("name")] = (str(kind[0]), str(kind[1]))
    return found


def need(found: dict[str, tuple[str, str]], name: str, kind: tuple[str, str]) -> None:
    """An error where a grid is not there, or of another kind."""
    if found.get(name) != kind:
        raise RuntimeError("there is no grid '%s' of %s, %s; the file has %s" % (name, *kind, found))
