"""What the examples share: sequences of .vdb files in Blender, and the nodes that show them.

Each of these has a trap in it that shows wrong without a word; the comments name them.
"""
import argparse
import os
import re
import sys

import bpy
from mathutils import Vector


def arguments(description):
    """The parser of all examples; `extend` it before `parse`."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("files", nargs="+", help=".vdb files: one, or the frames of a sequence")
    parser.add_argument("--colour", default="Cd", help="the colour grid's name (Cd)")
    parser.add_argument("--velocity", default="vel", help="the velocity grid's name (vel), used where there is one")
    parser.add_argument("--up", choices=("y", "z"), default="z", help="the axis that is up in the files (z)")
    parser.add_argument("--save", metavar="FILE.blend", help="save the scene")
    parser.add_argument("--render", metavar="FILE.png", help="render a frame with Cycles")
    parser.add_argument("--frame", type=int, help="the frame to show and to render (the first)")
    parser.add_argument("--size", type=int, default=512, help="edge of the picture in pixels (512)")
    parser.add_argument("--samples", type=int, default=64, help="samples a pixel (64)")
    return parser


def parse(parser, given=None):
    """What stands after `--` under `blender --python`, all of it under `python`."""
    if given is None:
        given = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    return parser.parse_args(given)


class Graph:
    """A geometry node tree, written as nested calls."""

    def __init__(self, name):
        self.tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
        self.tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")

    def add(self, kind, output=0, settings=None, **inputs):
        """A node with settings and inputs (by name, or i0, i1, ... by place); returns one of its outputs."""
        node = self.tree.nodes.new(kind)
        for key, value in (settings or {}).items():
            setattr(node, key, value)
        for key, value in inputs.items():
            place = re.fullmatch(r"i(\d+)", key)
            socket = node.inputs[int(place[1])] if place else node.inputs[key]
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            else:
                socket.default_value = value
        return node.outputs[output]

    def finish(self, geometry):
        out = self.tree.nodes.new("NodeGroupOutput")
        self.tree.links.new(geometry, out.inputs[0])
        return self.tree


def new_object(name, data):
    """An object with data, in the scene."""
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    return item


def last_number(path):
    """The number that Blender reads: the last run of digits before the extension."""
    found = re.search(r"(\d+)\.vdb$", os.path.basename(path))
    return int(found[1]) if found else None


def play(volume, files):
    """Makes a Volume play files, from the first number to the last."""
    volume.filepath = files[0]
    first, last = last_number(files[0]), last_number(files[-1])
    volume.is_sequence = True
    volume.frame_start = first
    volume.frame_offset = first - 1  # file number = frame - frame_start + 1 + frame_offset
    volume.frame_duration = last - first + 1  # 0, the default, would show nothing
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = first, last


def check_files(files):
    """Ends the program where Blender would show nothing, or something else, without saying so."""
    for path in files:
        if not os.path.exists(path):
            sys.exit("%s: there is no such file" % path)
    numbers = [last_number(path) for path in files]
    if len(files) == 1:
        return
    if None in numbers:
        sys.exit("%s: the frame's number has to stand last before .vdb" % files[numbers.index(None)])
    missing = sorted(set(range(numbers[0], numbers[-1] + 1)) - set(numbers))
    if missing:
        sys.exit("frames are missing, and would be shown as nothing: %s" % ", ".join(map(str, missing[:10])))


def open_volume(files, velocity="vel", up="z"):
    """A Volume object that plays .vdb files on the frames of their numbers, and the types of its grids by name."""
    files = sorted(map(os.path.abspath, files), key=lambda path: (last_number(path) or 0, path))
    check_files(files)
    name = os.path.basename(files[0]).split(".")[0]
    volume = bpy.data.volumes.new(name)
    volume.filepath = files[0]
    if not volume.grids.load():
        sys.exit("%s: %s" % (files[0], volume.grids.error_message))
    types = {}
    for grid in volume.grids:
        if not grid.load():  # a file that was cut opens; its grids do not load
            sys.exit("%s: grid '%s' does not load: the file is damaged" % (files[0], grid.name))
        types[grid.name] = grid.data_type
    if types.get(velocity) == "VECTOR_FLOAT":
        volume.velocity_grid = velocity  # while its grids are loaded: else the name is refused
    if len(files) > 1:
        play(volume, files)
    # Velocities are world units a second; Blender takes them for units a frame.
    volume.velocity_unit = "SECOND"
    # By default Cycles drops values under 0.001, and it crashes (5.0.1) where that is all of a velocity: at rest.
    volume.render.clipping = 0.0
    item = new_object(name, volume)
    if up == "y":
        item.rotation_euler.x = 1.5707963267948966  # a file has no axis: one with y up lies on its back
    set_rate(files[0])
    return item, types


def set_rate(path):
    """Frames a second, as the file says: the motion in a frame hangs on it."""
    # Blender brings OpenVDB's module along; where it is a module itself, off the path.
    version = "python%d.%d" % sys.version_info[:2]
    sys.path.append(os.path.join(bpy.utils.resource_path("LOCAL"), "python", "lib", version, "site-packages"))
    try:
        import openvdb
    except ImportError:
        return
    finally:
        sys.path.pop()
    rate = openvdb.readMetadata(path).get("hfvdb_fps")
    if rate:
        render = bpy.context.scene.render
        render.fps = max(1, round(rate))
        render.fps_base = render.fps / rate


def need(types, name, kind, what, help=""):
    """Ends the program where a grid is not there: a wrong name is no error in Blender, only nothing, or black."""
    if types.get(name) != kind:
        there = ", ".join("%s (%s)" % item for item in types.items()) or "none"
        sys.exit("there is no %s grid '%s' for the %s; the file has %s%s" % (kind, name, what, there, help))


def need_nodes(*kinds):
    """Ends the program where this Blender lacks nodes."""
    missing = [kind for kind in kinds if not hasattr(bpy.types, kind)]
    if missing:
        sys.exit("Blender %s has no node %s" % (bpy.app.version_string, ", ".join(missing)))


def voxel_size(volume, name):
    """The edge of a grid's voxels in its object's space, the same in every frame."""
    volume.data.grids.load()  # another frame drops them
    return volume.data.grids[name].matrix_object.to_scale()[0]


def new_material(name):
    """A material without nodes, its tree and its output's node."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    material.node_tree.nodes.clear()
    return material, material.node_tree, material.node_tree.nodes.new("ShaderNodeOutputMaterial")


def clear_startup():
    """Takes the cube out of Blender's own startup scene, and out of no other."""
    if not bpy.data.filepath and {item.name for item in bpy.data.objects} == {"Camera", "Cube", "Light"}:
        bpy.data.objects.remove(bpy.data.objects["Cube"])


def show_frame(options):
    """Goes to the frame that was asked for."""
    scene = bpy.context.scene
    scene.frame_set(scene.frame_start if options.frame is None else options.frame)


def finish(options, item, blur):
    """Camera, light, renderer, and what was asked to be written."""
    scene = bpy.context.scene
    show_frame(options)
    scene.view_settings.view_transform = "Standard"  # AgX, the default, changes colours
    scene.render.engine = "CYCLES"
    # 5.0's own way turns smoke with a colour channel of 0 blotchy and nearly black.
    scene.cycles.volume_biased = True
    scene.render.use_motion_blur = blur
    aim_camera(item)
    add_light()
    if options.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(options.save))
    if options.render:
        scene.cycles.samples = options.samples
        scene.render.resolution_x = scene.render.resolution_y = options.size
        scene.render.image_settings.file_format = "PNG"
        scene.render.filepath = os.path.abspath(options.render)
        bpy.ops.render.render(write_still=True)


def world_box(item):
    """The least and the greatest corner of an object's box in this frame."""
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    if item.type == "VOLUME":
        evaluated.data.grids.load()  # a volume has no box before
    corners = [item.matrix_world @ Vector(corner) for corner in evaluated.bound_box]
    low = Vector([min(corner[axis] for corner in corners) for axis in range(3)])
    high = Vector([max(corner[axis] for corner in corners) for axis in range(3)])
    return low, high


def aim_camera(item):
    """Looks at an object's box in this frame, from the front and above."""
    scene = bpy.context.scene
    if scene.camera is None:
        scene.camera = new_object("Camera", bpy.data.cameras.new("Camera"))
    low, high = world_box(item)
    towards = Vector((0.5, -1.0, 0.5)).normalized()
    lens = scene.camera.data
    slope = 0.5 * lens.sensor_width / lens.lens
    distance = 0.5 * (high - low).length / slope * 1.2
    lens.clip_start, lens.clip_end = min(lens.clip_start, distance / 100), max(lens.clip_end, 4 * distance)
    scene.camera.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
    scene.camera.location = (low + high) / 2 + towards * distance


def add_light():
    """A sun from over the camera's shoulder, in place of the lamp of Blender's own startup scene: that one stands a few
    units off and fades with the distance, so what is 100 units large, as in centimetres, would be nearly black."""
    lights = [item for item in bpy.data.objects if item.type == "LIGHT"]
    if bpy.data.filepath or [item.name for item in lights] not in ([], ["Light"]):
        return  # a scene of the user's own
    for item in lights:
        bpy.data.objects.remove(item)
    sun = new_object("Light", bpy.data.lights.new("Light", "SUN"))
    sun.data.energy = 4.0
    sun.rotation_euler = Vector((0.9, -0.6, 1.1)).to_track_quat("Z", "Y").to_euler()
