"""What the scripts for Blender share: a Volume object that plays .vdb files, and the node graph that a user would build
to make a coloured mesh of it.

Importing this starts Blender (`pip install bpy`, tried with 5.0.1) with nothing in it. Blender logs to stdout, so that
goes to stderr from here on; what a script has to say goes to `STDOUT`.
"""
import os
import sys

STDOUT = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

import bpy  # noqa: E402
import numpy as np  # noqa: E402

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "blender_examples"))
from hfvdb_blender import Graph, last_number, new_object  # noqa: E402

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.render.threads_mode, bpy.context.scene.render.threads = "FIXED", os.cpu_count() or 1


def coloured_mesh(volume, surface, colour, probe=None, material=None):
    """Get Named Grid, Grid to Mesh at threshold 0, and the colour grid (if any) sampled at the vertices.

    `probe` is a length: the field that far inside and outside of each vertex is stored as the attributes "inside" and
    "outside".
    """
    graph = Graph("coloured mesh")
    source = graph.add("GeometryNodeObjectInfo", "Geometry", {"transform_space": "RELATIVE"}, Object=volume)

    def grid(name, kind):
        settings = {"data_type": kind}
        return graph.add("GeometryNodeGetNamedGrid", "Grid", settings, Volume=source, Name=name, Remove=False)

    field = grid(surface, "FLOAT")
    mesh = graph.add("GeometryNodeGridToMesh", "Mesh", Grid=field, Threshold=0.0)  # Blender's default is 0.1
    position = graph.add("GeometryNodeInputPosition")

    def store(mesh, name, kind, value):
        settings = {"data_type": kind, "domain": "POINT"}
        return graph.add("GeometryNodeStoreNamedAttribute", "Geometry", settings, Geometry=mesh, Name=name, Value=value)

    for name, sign in (("inside", -1.0), ("outside", 1.0)) if probe else ():
        normal = graph.add("GeometryNodeInputNormal")
        step = graph.add("ShaderNodeVectorMath", settings={"operation": "SCALE"}, i0=normal, Scale=sign * probe)
        place = graph.add("ShaderNodeVectorMath", settings={"operation": "ADD"}, i0=position, i1=step)
        value = graph.add("GeometryNodeSampleGrid", "Value", {"data_type": "FLOAT"}, Grid=field, Position=place)
        mesh = store(mesh, name, "FLOAT", value)
    if colour:
        settings = {"data_type": "VECTOR"}
        vectors = grid(colour, "VECTOR")
        value = graph.add("GeometryNodeSampleGrid", "Value", settings, Grid=vectors, Position=position)
        mesh = store(mesh, colour, "FLOAT_COLOR", value)
    if material:
        mesh = graph.add("GeometryNodeSetMaterial", "Geometry", Geometry=mesh, Material=material)
    return graph.finish(mesh)


class Player:
    """A Volume object that shows one file after the other: as single files, or as one sequence (with or without gaps)."""

    def __init__(self, files, sequence=False):
        self.files, self.sequence = [os.path.abspath(path) for path in files], sequence
        self.volume = bpy.data.volumes.new("file")
        self.volume.filepath = self.files[0]
        if sequence:
            first, last = last_number(self.files[0]), last_number(self.files[-1])
            self.volume.is_sequence = True
            self.volume.frame_start = first
            self.volume.frame_offset = first - 1  # file number = frame - frame_start + 1 + frame_offset
            self.volume.frame_duration = last - first + 1  # 0, the default, would show nothing
            bpy.context.scene.frame_start, bpy.context.scene.frame_end = first, last
        self.object = new_object("file", self.volume)
        self.object.hide_render = True

    def show(self, index):
        """Shows a file; returns the path that Blender plays."""
        if self.sequence:
            bpy.context.scene.frame_set(last_number(self.files[index]))
        else:
            self.volume.filepath = self.files[index]
            self.object.update_tag()
        evaluated = self.object.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        evaluated.grids.load()
        return evaluated.grids.frame_filepath


def read_mesh(carrier):
    """The evaluated mesh of an object as arrays: positions and normals, corners of faces, their sizes, attributes of
    points."""
    evaluated = carrier.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()

    def array(source, name, width, kind=np.float32):
        flat = np.empty(len(source) * width, kind)
        source.foreach_get(name, flat)
        return flat.reshape(-1, width) if width > 1 else flat

    arrays = {
        "positions": array(mesh.vertices, "co", 3).astype(np.float64),
        "normals": array(mesh.vertices, "normal", 3).astype(np.float64),
        "corners": array(mesh.loops, "vertex_index", 1, np.int32),
        "sizes": array(mesh.polygons, "loop_total", 1, np.int32),
    }
    for attribute in mesh.attributes:
        if attribute.domain == "POINT" and attribute.data_type == "FLOAT":
            arrays[attribute.name] = array(attribute.data, "value", 1)
        elif attribute.domain == "POINT" and attribute.data_type == "FLOAT_COLOR":
            arrays[attribute.name] = array(attribute.data, "color", 4)[:, :3]
    evaluated.to_mesh_clear()
    return arrays


def leave(code):
    """Ends the program at once: Blender's own clean-up is noisy and can crash."""
    STDOUT.flush()
    sys.stderr.flush()
    os._exit(code)
