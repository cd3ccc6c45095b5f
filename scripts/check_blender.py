#!/usr/bin/env python3
"""Opens .vdb files in real Blender and says what an artist would get.

    python check_blender.py FILE.vdb [FILE.vdb ...] [options]

Needs a Python that has Blender as a module (`pip install bpy`, tried with 5.0.1). The files go through the node
graph that a user would build: Get Named Grid, Grid to Mesh at threshold 0, and the colour grid sampled at the
vertices into a colour attribute.

Problems are reported, and end the run with exit code 1, when
  * the file or one of its grids does not load, or a grid is of the wrong type;
  * the mesh is empty, not closed, not oriented alike everywhere, or inside out;
  * a voxel's length inside and outside of a vertex the field is not a voxel's length: wrong sign, wrong units, a
    second surface at the inner edge of a band that was not filled;
  * colours are missing (most vertices black), not finite, or outside [0, 1];
  * with --sequence: frame n does not play file n.

stdout is one JSON document; --dump writes what it was computed from, to be compared with exact values.
"""
import argparse
import json
import math
import os
import re
import sys

STDOUT = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)  # Blender logs to stdout, which is the report's

import bpy  # noqa: E402
import mathutils  # noqa: E402
import numpy as np  # noqa: E402

# How far the field may be from a voxel's length one voxel off the surface, in voxels: near creases it is shorter.
FIELD_TOLERANCE = 0.5
# The fraction of vertices that has to hold it.
FIELD_FRACTION = 0.9


def arguments():
    parser = argparse.ArgumentParser(description="check .vdb files in Blender")
    parser.add_argument("files", nargs="+", help=".vdb files; with --sequence the frames, in order")
    parser.add_argument("--surface", default="surface", help="the level set's name")
    parser.add_argument("--colour", default="Cd", help="the colour grid's name, or 'none'")
    parser.add_argument("--sequence", action="store_true", help="load the files as one sequence and play it")
    parser.add_argument("--dump", metavar="FOLDER", help="write FOLDER/NAME.npz: positions, colours, corners, sizes")
    parser.add_argument("--render", metavar="PNG", help="render the frames into one contact sheet")
    parser.add_argument("--pick", type=int, default=12, help="render at most so many frames, evenly spread (12)")
    parser.add_argument("--size", type=int, default=160, help="edge of a rendered frame in pixels (160)")
    parser.add_argument("--samples", type=int, default=8, help="samples a pixel (8)")
    return parser.parse_args()


# --- the scene -------------------------------------------------------------------------------------------------------


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


def build_graph(volume, surface, colour, voxel, material):
    graph = Graph("check")
    source = graph.add("GeometryNodeObjectInfo", "Geometry", {"transform_space": "RELATIVE"}, Object=volume)

    def grid(name, kind):
        settings = {"data_type": kind}
        return graph.add("GeometryNodeGetNamedGrid", "Grid", settings, Volume=source, Name=name, Remove=False)

    field = grid(surface, "FLOAT")
    mesh = graph.add("GeometryNodeGridToMesh", "Mesh", Grid=field, Threshold=0.0)  # Blender's default is 0.1
    position = graph.add("GeometryNodeInputPosition")
    normal = graph.add("GeometryNodeInputNormal")

    def store(mesh, name, kind, value):
        settings = {"data_type": kind, "domain": "POINT"}
        return graph.add("GeometryNodeStoreNamedAttribute", "Geometry", settings, Geometry=mesh, Name=name, Value=value)

    for name, sign in (("inside", -1.0), ("outside", 1.0)):
        step = graph.add("ShaderNodeVectorMath", settings={"operation": "SCALE"}, i0=normal, Scale=sign * voxel)
        place = graph.add("ShaderNodeVectorMath", settings={"operation": "ADD"}, i0=position, i1=step)
        value = graph.add("GeometryNodeSampleGrid", "Value", {"data_type": "FLOAT"}, Grid=field, Position=place)
        mesh = store(mesh, name, "FLOAT", value)
    if colour:
        settings = {"data_type": "VECTOR"}
        vectors = grid(colour, "VECTOR")
        value = graph.add("GeometryNodeSampleGrid", "Value", settings, Grid=vectors, Position=position)
        mesh = store(mesh, colour, "FLOAT_COLOR", value)
    return graph.finish(graph.add("GeometryNodeSetMaterial", "Geometry", Geometry=mesh, Material=material))


def make_material(colour):
    material = bpy.data.materials.new("surface")
    if material.node_tree is None:
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shader, out = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    links.new(shader.outputs[0], out.inputs["Surface"])
    if colour:
        attribute = nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = colour
        links.new(attribute.outputs["Color"], shader.inputs["Color"])
    return material


def last_number(path):
    """The number that Blender reads: the last run of digits before the extension."""
    found = re.search(r"(\d+)\.vdb$", os.path.basename(path))
    return int(found[1]) if found else None


class Player:
    """A Volume object that shows one file after the other: as single files, or as one sequence."""

    def __init__(self, files, sequence):
        self.files, self.sequence = [os.path.abspath(path) for path in files], sequence
        self.volume = bpy.data.volumes.new("file")
        self.volume.filepath = self.files[0]
        if sequence:
            first = last_number(self.files[0])
            self.volume.is_sequence = True
            self.volume.frame_start = first
            self.volume.frame_offset = first - 1  # file number = frame - frame_start + 1 + frame_offset
            last = last_number(self.files[-1])
            self.volume.frame_duration = last - first + 1  # 0, the default, would show nothing
            bpy.context.scene.frame_start, bpy.context.scene.frame_end = first, last
        self.object = bpy.data.objects.new("file", self.volume)
        self.object.hide_render = True
        bpy.context.scene.collection.objects.link(self.object)

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


# --- what is checked -------------------------------------------------------------------------------------------------


def check_grids(path, wanted, problems):
    """Loads a file by itself. Returns its grids, and the voxel size of the first wanted one."""
    volume = bpy.data.volumes.new("probe")
    volume.filepath = os.path.abspath(path)
    grids, voxel = {}, None
    if not volume.grids.load():
        problems.append("does not open: " + volume.grids.error_message)
    for grid in volume.grids:
        if grid.name in grids:
            problems.append("two grids are called '%s'" % grid.name)
        loads = bool(grid.load())  # a file that was cut opens; its grids do not load
        if not loads:
            problems.append("grid '%s' does not load" % grid.name)
        grids[grid.name] = {"type": grid.data_type, "loads": loads}
        if grid.name == wanted[0][0]:
            columns = np.array(grid.matrix_object)[:3, :3]
            lengths = np.linalg.norm(columns, axis=0)
            voxel = float(lengths[0])
            if np.ptp(lengths) > 1e-6 * voxel:
                problems.append("voxels are no cubes: %s" % lengths.tolist())
    for name, kind in wanted:
        if name not in grids:
            problems.append("there is no grid '%s'" % name)
        elif grids[name]["type"] != kind:
            problems.append("grid '%s' is %s, not %s" % (name, grids[name]["type"], kind))
    bpy.data.volumes.remove(volume)
    return grids, voxel


def read_mesh(carrier):
    """The evaluated mesh as arrays."""
    evaluated = carrier.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()

    def array(source, name, width, kind=np.float32):
        flat = np.empty(len(source) * width, kind)
        source.foreach_get(name, flat)
        return flat.reshape(-1, width) if width > 1 else flat

    arrays = {
        "positions": array(mesh.vertices, "co", 3).astype(np.float64),
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


def directed_edges(corners, sizes):
    ends = np.cumsum(sizes)
    following = np.arange(1, len(corners) + 1)
    following[ends - 1] = ends - sizes
    return np.stack([corners, corners[following]], 1).astype(np.int64)


def signed_volume(positions, corners, sizes):
    """Positive when normals point outwards."""
    points = positions - positions.mean(0)
    starts = np.cumsum(sizes) - sizes
    total = 0.0
    for step in range(1, int(sizes.max()) - 1):
        faces = starts[sizes > step + 1]
        a, b, c = (points[corners[faces + offset]] for offset in (0, step, step + 1))
        total += float((a * np.cross(b, c)).sum()) / 6
    return total


def count_pieces(count, edges):
    """Connected pieces, by spreading the least vertex number along the edges."""
    label = np.arange(count)
    while True:
        before = label.copy()
        np.minimum.at(label, edges[:, 0], label[edges[:, 1]])
        np.minimum.at(label, edges[:, 1], label[edges[:, 0]])
        label = label[label]
        if (label == before).all():
            return len(np.unique(label))


def check_mesh(mesh, colour, voxel, problems):
    positions, corners, sizes = mesh["positions"], mesh["corners"], mesh["sizes"]
    facts = {"vertices": len(positions), "faces": len(sizes)}
    if len(sizes) == 0:
        problems.append("there is no mesh")
        return facts
    edges = directed_edges(corners, sizes)
    width = len(positions) + 1
    key, twin = edges[:, 0] * width + edges[:, 1], edges[:, 1] * width + edges[:, 0]
    facts["closed"] = bool(np.isin(key, twin).all())
    facts["pieces"] = count_pieces(len(positions), edges)
    facts["signed_volume"] = signed_volume(positions, corners, sizes)
    facts["box"] = [positions.min(0).tolist(), positions.max(0).tolist()]
    if not facts["closed"]:
        problems.append("the mesh is open, or its faces are not oriented alike")
    if facts["signed_volume"] <= 0:
        problems.append("the mesh is inside out: wrong sign or wrong class")
    error = np.maximum(abs(mesh["inside"] + voxel), abs(mesh["outside"] - voxel)) / voxel
    facts["field_good"] = float((error < FIELD_TOLERANCE).mean())
    facts["field_error_mean"] = float(error.mean())
    if facts["field_good"] < FIELD_FRACTION:
        problems.append("the field is no distance beside %.1f %% of the vertices" % (100 * (1 - facts["field_good"])))
    if colour:
        facts["colour"] = check_colour(mesh.get(colour), problems)
    return facts


def check_colour(values, problems):
    if values is None:
        problems.append("the mesh has no colours")
        return None
    if not np.isfinite(values).all():
        problems.append("colours that are not finite")
    if values.min() < -1e-4 or values.max() > 1 + 1e-4:
        problems.append("colours outside [0, 1]: %g to %g" % (values.min(), values.max()))
    black = float((values == 0).all(1).mean())
    if black > 0.5:
        problems.append("%.0f %% of the vertices are black: no colour there" % (100 * black))
    return {"mean": values.mean(0).tolist(), "least": values.min(0).tolist(), "greatest": values.max(0).tolist()}


# --- pictures --------------------------------------------------------------------------------------------------------


def set_up_render(low, high, size, samples):
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
    scene.cycles.samples, scene.cycles.use_denoising = samples, False
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.film_transparent = False
    scene.render.image_settings.file_format = "PNG"
    scene.view_settings.view_transform = "Standard"  # the default changes colours
    world = bpy.data.worlds.new("world")
    scene.world = world
    if world.node_tree is None:
        world.use_nodes = True
    background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs[0].default_value, background.inputs[1].default_value = (1, 1, 1, 1), 0.6
    centre, diagonal = (low + high) / 2, float(np.linalg.norm(high - low))
    towards = mathutils.Vector((0.45, -1.0, 0.4)).normalized()
    lens = bpy.data.cameras.new("camera")
    lens.type, lens.ortho_scale, lens.clip_end = "ORTHO", diagonal * 1.02, diagonal * 10
    camera = bpy.data.objects.new("camera", lens)
    camera.location = mathutils.Vector(centre) + towards * diagonal * 3
    camera.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 2.0, (0.7, 0.2, 0.4)
    for item in (camera, sun):
        scene.collection.objects.link(item)
    scene.camera = camera


def load_pixels(path):
    image = bpy.data.images.load(path)
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)  # the lowest row first


def save_pixels(path, pixels):
    image = bpy.data.images.new("sheet", pixels.shape[1], pixels.shape[0])
    image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).ravel())
    image.filepath_raw, image.file_format = os.path.abspath(path), "PNG"
    image.save()


def render_sheet(player, chosen, path, size):
    columns = math.ceil(math.sqrt(len(chosen) * 1.5))
    rows = math.ceil(len(chosen) / columns)
    sheet = np.ones((rows * size, columns * size, 4), np.float32)
    single = os.path.abspath(path) + ".frame.png"
    for place, index in enumerate(chosen):
        player.show(index)
        bpy.context.scene.render.filepath = single
        bpy.ops.render.render(write_still=True)
        row, column = rows - 1 - place // columns, place % columns
        sheet[row * size:(row + 1) * size, column * size:(column + 1) * size] = load_pixels(single)
    os.remove(single)
    save_pixels(path, sheet)


# --- the run ---------------------------------------------------------------------------------------------------------


def main(options):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.threads_mode, bpy.context.scene.render.threads = "FIXED", os.cpu_count() or 1
    colour = None if options.colour == "none" else options.colour
    wanted = [(options.surface, "FLOAT")] + ([(colour, "VECTOR_FLOAT")] if colour else [])
    report = {"blender": bpy.app.version_string, "frames": []}
    player, material = Player(options.files, options.sequence), make_material(colour)
    carrier = bpy.data.objects.new("mesh", bpy.data.meshes.new("mesh"))
    bpy.context.scene.collection.objects.link(carrier)
    modifier, graph_voxel = carrier.modifiers.new("check", "NODES"), None
    for index, path in enumerate(player.files):
        problems = []
        frame = {"file": path, "problems": problems}
        report["frames"].append(frame)
        frame["grids"], voxel = check_grids(path, wanted, problems)
        if problems:
            continue
        frame["voxel_size"] = voxel
        if voxel != graph_voxel:
            modifier.node_group = build_graph(player.object, options.surface, colour, voxel, material)
            graph_voxel = voxel
        playing = player.show(index)
        if os.path.abspath(bpy.path.abspath(playing)) != path:
            problems.append("Blender plays '%s' instead" % playing)
        mesh = read_mesh(carrier)
        frame["mesh"] = check_mesh(mesh, colour, voxel, problems)
        if options.dump:
            os.makedirs(options.dump, exist_ok=True)
            stem = os.path.join(options.dump, os.path.splitext(os.path.basename(path))[0])
            mesh["positions"].astype("<f4").tofile(stem + ".positions.f32")
            if colour in mesh:
                mesh[colour].astype("<f4").tofile(stem + ".colours.f32")
    report["problems"] = [os.path.basename(f["file"]) + ": " + text for f in report["frames"] for text in f["problems"]]
    shown = [index for index, frame in enumerate(report["frames"]) if frame.get("mesh", {}).get("faces")]
    if options.render and shown:
        boxes = np.array([report["frames"][index]["mesh"]["box"] for index in shown])
        set_up_render(boxes[:, 0].min(0), boxes[:, 1].max(0), options.size, options.samples)
        spread = np.linspace(0, len(shown) - 1, min(options.pick, len(shown))).round().astype(int)
        render_sheet(player, [shown[place] for place in spread], options.render, options.size)
        report["render"] = options.render
    return report


if __name__ == "__main__":
    OPTIONS = arguments()
    if OPTIONS.sequence and any(last_number(path) is None for path in OPTIONS.files):
        sys.exit("a sequence needs file names that end in a number before .vdb")
    REPORT = main(OPTIONS)
    STDOUT.write(json.dumps(REPORT, indent=1) + "\n")
    STDOUT.flush()
    # Blender's own clean-up is noisy and can crash; the report is complete.
    sys.stderr.flush()
    os._exit(1 if REPORT["problems"] else 0)
