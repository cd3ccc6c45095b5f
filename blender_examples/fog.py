"""A sequence of .vdb files with a density as coloured smoke; with motion blur where the files have a velocity.

    blender --python fog.py -- out/cloud.*.vdb
    blender --background --python fog.py -- out/cloud.*.vdb --frame 24 --render cloud.png --save cloud.blend
    python fog.py out/cloud.*.vdb --render cloud.png                 with Blender as a module: pip install bpy==5.0.1

The colour has to reach through all of the smoke: `hfvdb check FILE.vdb --for blender` tells whether it does.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

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


def main(given=None):
    """Returns the volume's object."""
    parser = hfvdb.arguments("a sequence of .vdb files as coloured smoke")
    parser.add_argument("--density", default="density", help="the density grid's name (density)")
    parser.add_argument("--thickness", type=float, default=10.0, help="what the density is multiplied by (10)")
    options = hfvdb.parse(parser, given)
    hfvdb.clear_startup()
    volume, types = hfvdb.open_volume(options.files, options.velocity, options.up)
    # A level set is none: all that is far outside would be smoke.
    hfvdb.need(types, options.density, "FLOAT", "smoke")
    colour = options.colour if types.get(options.colour) == "VECTOR_FLOAT" else None
    has_velocity = types.get(options.velocity) == "VECTOR_FLOAT"
    volume.data.materials.append(smoke(options.density, colour, options.thickness))
    hfvdb.finish(options, volume, blur=has_velocity)
    return volume


if __name__ == "__main__":
    main()
