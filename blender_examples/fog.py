"""A sequence of .vdb files as coloured smoke; with motion blur where the files have a velocity.

    blender --python fog.py -- out/cloud.*.vdb
    blender --background --python fog.py -- out/cloud.*.vdb --frame 24 --render cloud.png --save cloud.blend
    python fog.py out/cloud.*.vdb --render cloud.png                 with Blender as a module: pip install bpy==5.0.1

The smoke is that of the file's density. Where it has none, as those of hfvdb, its level set is filled with smoke: dense
inside, thinning out over the last three voxels below the surface. The colour has to reach through all of the smoke
(`hfvdb check FILE.vdb --for blender` tells whether it does); further inside than colours reach, smoke has their background,
which in files of hfvdb is their mean. Needs Blender 5.0; tried in 5.0.1.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bpy  # noqa: E402
import hfvdb_blender as hfvdb  # noqa: E402


def smoke(density, colour, thickness):
    """Smoke of a density grid in the colours of another grid, which may be None."""
    material, tree, out = hfvdb.new_material("smoke")
    shader = tree.nodes.new("ShaderNodeVolumePrincipled")
    shader.inputs["Color"].default_value = (1, 1, 1, 1)  # it multiplies, and is half grey
    shader.inputs["Density Attribute"].default_value = ""
    amount = tree.nodes.new("ShaderNodeAttribute")
    amount.attribute_name = density
    times = tree.nodes.new("ShaderNodeMath")
    times.operation = "MULTIPLY"
    times.inputs[1].default_value = thickness
    tree.links.new(amount.outputs["Fac"], times.inputs[0])
    tree.links.new(times.outputs[0], shader.inputs["Density"])
    if colour is not None:
        attribute = tree.nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = colour  # a wrong name is black smoke
        tree.links.new(attribute.outputs["Color"], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], out.inputs["Volume"])
    return material


def filled(volume, surface, density):
    """The node tree that adds a density to a volume with a level set: 1 inside, less below the surface."""
    hfvdb.need_nodes("GeometryNodeGridToMesh", "GeometryNodeMeshToDensityGrid", "GeometryNodeStoreNamedGrid")
    graph = hfvdb.Graph("smoke")
    graph.tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    source = graph.tree.nodes.new("NodeGroupInput").outputs[0]
    edge = hfvdb.voxel_size(volume, surface)
    level_set = graph.add(
        "GeometryNodeGetNamedGrid", "Grid", {"data_type": "FLOAT"}, Volume=source, Name=surface, Remove=False)
    mesh = graph.add("GeometryNodeGridToMesh", "Mesh", Grid=level_set, Threshold=0.0)
    grid = graph.add(
        "GeometryNodeMeshToDensityGrid", "Density Grid", Mesh=mesh, **{"Voxel Size": edge, "Gradient Width": 3 * edge})
    stored = graph.add(
        "GeometryNodeStoreNamedGrid", "Volume", {"data_type": "FLOAT"}, Volume=source, Name=density, Grid=grid)
    return graph.finish(stored)


def main(given=None):
    """Returns the volume's object."""
    parser = hfvdb.arguments("a sequence of .vdb files as coloured smoke")
    parser.add_argument("--density", default="density", help="the density grid's name (density)")
    parser.add_argument("--surface", default="surface", help="the level set to fill where there is no density (surface)")
    parser.add_argument("--thickness", type=float, help="what the density is multiplied by (12 over the longest side)")
    options = hfvdb.parse(parser, given)
    if bpy.app.version < (5, 0, 0):
        # Volumes stand half a voxel off there, along x, y and z, but for their colours.
        sys.exit("this needs Blender 5.0 or newer; this is %s" % bpy.app.version_string)
    hfvdb.clear_startup()
    volume, types = hfvdb.open_volume(options.files, options.velocity, options.up)
    hfvdb.show_frame(options)
    if types.get(options.density) != "FLOAT":
        # A level set itself is none: all that is far outside would be smoke.
        help = "; --density names another, --surface a level set to be filled with smoke"
        hfvdb.need(types, options.surface, "FLOAT", "smoke", help)
        print("there is no grid '%s': '%s' is filled with smoke" % (options.density, options.surface), file=sys.stderr)
        volume.modifiers.new("smoke", "NODES").node_group = filled(volume, options.surface, options.density)
    colour = options.colour if types.get(options.colour) == "VECTOR_FLOAT" else None
    has_velocity = types.get(options.velocity) == "VECTOR_FLOAT"
    thickness = options.thickness
    if thickness is None:
        low, high = hfvdb.world_box(volume)
        thickness = 12 / max(high - low)
    volume.data.materials.append(smoke(options.density, colour, thickness))
    hfvdb.finish(options, volume, blur=has_velocity)
    return volume


if __name__ == "__main__":
    main()
