"""A sequence of .vdb files as a coloured mesh, by Geometry Nodes; with motion blur where the files have a velocity.

    blender --python mesh.py -- out/cubism.*.vdb
    blender --background --python mesh.py -- out/cubism.*.vdb --frame 24 --render cubism.png --save cubism.blend
    python mesh.py out/cubism.*.vdb --render cubism.png              with Blender as a module: pip install bpy==5.0.1

Tried with Blender 5.0.1, 4.5.15 LTS and 4.2.23 LTS.

Makes two objects: the volume, which is not rendered, and the mesh, which follows it over the frames. Apply the
modifier to get a real mesh with the colour attribute `Cd`.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bpy  # noqa: E402
import hfvdb_blender as hfvdb  # noqa: E402


def paint(colour):
    """Dull paint in the colours of an attribute."""
    material, tree, out = hfvdb.new_material("paint")
    shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
    shader.inputs["Roughness"].default_value = 0.6
    attribute = tree.nodes.new("ShaderNodeAttribute")
    attribute.attribute_name = colour  # a wrong name is black
    tree.links.new(attribute.outputs["Color"], shader.inputs["Base Color"])
    tree.links.new(shader.outputs[0], out.inputs["Surface"])
    return material


def coloured_mesh(volume, surface, colour, velocity):
    """The node tree: the level set's mesh, with colour and velocity sampled at its vertices. Either may be None."""
    hfvdb.need_nodes("GeometryNodeGetNamedGrid", "GeometryNodeGridToMesh", "GeometryNodeSampleGrid")
    graph = hfvdb.Graph("coloured mesh")
    source = graph.add("GeometryNodeObjectInfo", "Geometry", {"transform_space": "RELATIVE"}, Object=volume)

    def grid(name, kind):
        return graph.add(
            "GeometryNodeGetNamedGrid", "Grid", {"data_type": kind}, Volume=source, Name=name, Remove=False)

    # Not the node Volume to Mesh, which meshes every grid of numbers. Blender's threshold is 0.1, a distance: it would
    # make the object grow by that.
    mesh = graph.add("GeometryNodeGridToMesh", "Mesh", Grid=grid(surface, "FLOAT"), Threshold=0.0)
    if bpy.app.version < (5, 0, 0):
        # There a mesh stands half a voxel off along x, y and z, and what is sampled at its vertices does not.
        half = -0.5 * hfvdb.voxel_size(volume, surface)
        mesh = graph.add("GeometryNodeSetPosition", "Geometry", Geometry=mesh, Offset=(half, half, half))
    position = graph.add("GeometryNodeInputPosition")
    # The renderer knows a velocity by the name `velocity`, and by no other.
    for name, stored, kind in ((colour, colour, "FLOAT_COLOR"), (velocity, "velocity", "FLOAT_VECTOR")):
        if name is None:
            continue
        vectors = grid(name, "VECTOR")  # there is no grid of colours; read as Float it would be grey
        value = graph.add("GeometryNodeSampleGrid", "Value", {"data_type": "VECTOR"}, Grid=vectors, Position=position)
        settings = {"data_type": kind, "domain": "POINT"}
        mesh = graph.add("GeometryNodeStoreNamedAttribute", "Geometry", settings, Geometry=mesh, Name=stored, Value=value)
    if colour is not None:
        mesh = graph.add("GeometryNodeSetMaterial", "Geometry", Geometry=mesh, Material=paint(colour))
    return graph.finish(mesh)


def main(given=None):
    """Returns the mesh's object."""
    parser = hfvdb.arguments("a sequence of .vdb files as a coloured mesh")
    parser.add_argument("--surface", default="surface", help="the level set's name (surface)")
    options = hfvdb.parse(parser, given)
    hfvdb.clear_startup()
    volume, types = hfvdb.open_volume(options.files, options.velocity, options.up)
    hfvdb.show_frame(options)
    hfvdb.need(types, options.surface, "FLOAT", "surface")
    there = [name if types.get(name) == "VECTOR_FLOAT" else None for name in (options.colour, options.velocity)]
    if there[0] is None:
        print("there is no grid '%s': the mesh has no colours" % options.colour, file=sys.stderr)
    volume.hide_render = True
    mesh = hfvdb.new_object(volume.name + " mesh", bpy.data.meshes.new("mesh"))
    mesh.modifiers.new("coloured mesh", "NODES").node_group = coloured_mesh(volume, options.surface, *there)
    hfvdb.finish(options, mesh, blur=there[1] is not None)
    return mesh


if __name__ == "__main__":
    main()
