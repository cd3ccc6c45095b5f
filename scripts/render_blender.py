#!/usr/bin/env python3
"""Renders sequences of .vdb files in real Blender (Cycles) into one picture: a contact sheet.

    python render_blender.py FOLDER [FOLDER ...] --output SHEET.png [options]

Needs a Python that has Blender as a module (`pip install bpy`, tried with 5.0.1). Each folder is one sequence, and
starts a new row. Colours are as in the files: the view transform is Standard. The ground catches shadows only.
"""
import argparse
import glob
import os
import sys
import tempfile

from blender_scene import Player, STDOUT, bpy, coloured_mesh, last_number, leave, new_object, np, read_mesh
from mathutils import Matrix, Vector

PAPER = 0.86  # of the sheet, as stored
TOWARDS = Vector((0.5, -1.0, 0.5)).normalized()  # from the object to the camera


def arguments():
    parser = argparse.ArgumentParser(description="render .vdb files in Blender into a contact sheet")
    parser.add_argument("folders", nargs="+", help="folders with the .vdb files of one sequence each")
    parser.add_argument("--output", required=True, type=os.path.abspath, help="the PNG to write")
    parser.add_argument("--surface", default="surface", help="the level set's name")
    parser.add_argument("--colour", default="Cd", help="the colour grid's name")
    parser.add_argument("--pictures", type=int, default=12, help="at most so many of each sequence, evenly spread (12)")
    parser.add_argument("--columns", type=int, default=6, help="pictures in a row (6)")
    parser.add_argument("--size", type=int, default=240, help="edge of a picture in pixels (240)")
    parser.add_argument("--samples", type=int, default=48, help="samples a pixel, before denoising (48)")
    return parser.parse_args()


def make_material(name, colour):
    """Dull paint in the colours of an attribute, or, with a number, a grey that needs no light."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    out = nodes.new("ShaderNodeOutputMaterial")
    if isinstance(colour, float):
        shader = nodes.new("ShaderNodeEmission")
        shader.inputs["Color"].default_value = (colour, colour, colour, 1)
    else:
        shader = nodes.new("ShaderNodeBsdfPrincipled")
        shader.inputs["Roughness"].default_value = 0.6
        shader.inputs["Specular IOR Level"].default_value = 0.2
        attribute = nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = colour
        links.new(attribute.outputs["Color"], shader.inputs["Base Color"])
    links.new(shader.outputs[0], out.inputs["Surface"])
    return material


def set_up(size, samples):
    """Renderer and light: a soft sun from the left, and a sky from all around."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
    scene.cycles.samples, scene.cycles.use_denoising = samples, True
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.film_transparent = True
    scene.render.image_settings.file_format = "PNG"
    scene.view_settings.view_transform = "Standard"  # the default changes colours
    world = bpy.data.worlds.new("world")
    scene.world = world
    if world.node_tree is None:
        world.use_nodes = True
    background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (0.9, 0.95, 1, 1), 0.45
    sun = new_object("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle = 2.1, 0.35
    sun.rotation_euler = Vector((-0.3, -0.8, 1.1)).to_track_quat("Z", "Y").to_euler()


def add_ground(height, size):
    mesh = bpy.data.meshes.new("ground")
    corners = [(-size, -size, height), (size, -size, height), (size, size, height), (-size, size, height)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    new_object("ground", mesh).is_shadow_catcher = True


class Camera:
    """Looks at the middle of one box after the other, from a distance at which all of them fit in."""

    def __init__(self, boxes):
        lens = bpy.data.cameras.new("camera")
        lens.lens, lens.sensor_width = 70, 36
        self.object = new_object("camera", lens)
        bpy.context.scene.camera = self.object
        self.turn = TOWARDS.to_track_quat("Z", "Y")
        slope = 0.5 * lens.sensor_width / lens.lens
        self.distance = 0.0
        for low, high in boxes:
            for corner in range(8):
                half = Vector([(high[i] - low[i]) * (0.5 if corner >> i & 1 else -0.5) for i in range(3)])
                across, up, near = self.turn.inverted() @ half
                self.distance = max(self.distance, near + max(abs(across), abs(up)) / (0.84 * slope))
        self.label = new_object("label", bpy.data.curves.new("label", "FONT"))
        self.label.data.align_x, self.label.data.size = "CENTER", 0.075
        self.label.data.materials.append(make_material("ink", 0.05))
        for rays in ("diffuse", "glossy", "shadow", "transmission"):
            setattr(self.label, "visible_" + rays, False)
        # One unit before the camera, at the lower edge of the picture.
        self.to_label = Matrix.Translation((0, -0.95 * slope, -1)) @ Matrix.Scale(slope, 4)

    def look(self, low, high, text):
        middle = Vector([(low[i] + high[i]) / 2 for i in range(3)])
        self.object.matrix_world = Matrix.Translation(middle + TOWARDS * self.distance) @ self.turn.to_matrix().to_4x4()
        self.label.data.body = text
        self.label.matrix_world = self.object.matrix_world @ self.to_label


def render(path):
    """Renders, and returns the picture on paper, the lowest row first."""
    bpy.context.scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path)
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    pixels = pixels.reshape(height, width, 4)
    alpha = pixels[:, :, 3:]
    return pixels[:, :, :3] * alpha + PAPER * (1 - alpha)


def save(path, pixels):
    image = bpy.data.images.new("sheet", pixels.shape[1], pixels.shape[0])
    opaque = np.ones(pixels.shape[:2] + (4,), np.float32)
    opaque[:, :, :3] = pixels
    image.pixels.foreach_set(opaque.ravel())
    settings = bpy.context.scene.render.image_settings
    settings.color_mode, settings.compression = "RGB", 100
    image.save_render(path, scene=bpy.context.scene)  # with the view transform Standard, as it is


def main(options):
    set_up(options.size, options.samples)
    carrier = new_object("mesh", bpy.data.meshes.new("mesh"))
    modifier, material = carrier.modifiers.new("mesh", "NODES"), make_material("paint", options.colour)
    shots = []  # a player, the number of its file, where in the sheet
    row = 0
    for folder in options.folders:
        files = sorted(glob.glob(os.path.join(glob.escape(folder), "*.vdb")))
        if not files:
            sys.exit("%s: no .vdb files" % folder)
        player = Player(files)
        graph = coloured_mesh(player.object, options.surface, options.colour, material=material)
        spread = np.linspace(0, len(files) - 1, min(options.pictures, len(files))).round().astype(int)
        for place, index in enumerate(spread):
            shots.append((player, graph, int(index), row + place // options.columns, place % options.columns))
        row += -(-len(spread) // options.columns)

    def show(player, graph, index):
        modifier.node_group = graph
        player.show(index)

    boxes = []
    for player, graph, index, *_ in shots:
        show(player, graph, index)
        positions = read_mesh(carrier)["positions"]
        if len(positions) == 0:
            sys.exit("%s: no mesh" % player.files[index])
        boxes.append((positions.min(0), positions.max(0)))
    camera = Camera(boxes)
    add_ground(min(low[2] for low, _ in boxes), 100 * camera.distance)
    size = options.size
    sheet = np.full((row * size, min(options.columns, max(place[4] for place in shots) + 1) * size, 3), PAPER, np.float32)
    with tempfile.TemporaryDirectory() as folder:
        for (player, graph, index, down, across), box in zip(shots, boxes):
            show(player, graph, index)
            number = last_number(player.files[index])
            camera.look(*box, "" if number is None else str(number))
            top = (row - 1 - down) * size
            sheet[top:top + size, across * size:(across + 1) * size] = render(os.path.join(folder, "frame.png"))
    save(options.output, sheet)


if __name__ == "__main__":
    OPTIONS = arguments()
    main(OPTIONS)
    STDOUT.write(OPTIONS.output + "\n")
    leave(0)
