"""Renders the mesh of one .vdb file in Blender (Cycles) without and with motion blur by its `vel`: usage motion_blur.py FILE.

The graph samples `vel` at the vertices and stores it as the attribute "velocity", which Cycles blurs by. One line a
shutter of 0, 0.5 and 1 frames: what it is, and how wide the object is in the middle row of the picture in world units:
where anything of it is seen, and where nothing else is.
"""
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scripts"))
from blender_scene import STDOUT, Graph, Player, bpy, leave, new_object, np  # noqa: E402

WIDTH, HEIGHT, ACROSS = 400, 100, 2.0


def blurred_mesh(volume):
    graph = Graph("blurred mesh")
    source = graph.add("GeometryNodeObjectInfo", "Geometry", {"transform_space": "RELATIVE"}, Object=volume)

    def grid(name, kind):
        return graph.add("GeometryNodeGetNamedGrid", "Grid", {"data_type": kind}, Volume=source, Name=name, Remove=False)

    mesh = graph.add("GeometryNodeGridToMesh", "Mesh", Grid=grid("surface", "FLOAT"), Threshold=0.0)
    position = graph.add("GeometryNodeInputPosition")
    settings = {"data_type": "VECTOR"}
    velocity = graph.add("GeometryNodeSampleGrid", "Value", settings, Grid=grid("vel", "VECTOR"), Position=position)
    settings = {"data_type": "FLOAT_VECTOR", "domain": "POINT"}
    store = {"Geometry": mesh, "Name": "velocity", "Value": velocity}
    return graph.finish(graph.add("GeometryNodeStoreNamedAttribute", "Geometry", settings, **store))


def widths(shutter, path):
    scene = bpy.context.scene
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = shutter > 0, shutter or 1.0
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path)
    pixels = np.empty(WIDTH * HEIGHT * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    alpha = pixels.reshape(HEIGHT, WIDTH, 4)[HEIGHT // 2 - 2:HEIGHT // 2 + 2, :, 3].mean(0)
    pixel = ACROSS / WIDTH
    return (alpha > 0.02).sum() * pixel, (alpha > 0.98).sum() * pixel


player = Player([sys.argv[1]])
carrier = new_object("mesh", bpy.data.meshes.new("mesh"))
carrier.modifiers.new("mesh", "NODES").node_group = blurred_mesh(player.object)
player.show(0)
scene = bpy.context.scene
scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 64
scene.render.fps, scene.render.film_transparent = 24, True
scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
lens = bpy.data.cameras.new("camera")
lens.type, lens.ortho_scale = "ORTHO", ACROSS
camera = new_object("camera", lens)
camera.location, camera.rotation_euler = (0, -5, 0), (np.pi / 2, 0, 0)
scene.camera = camera
with tempfile.TemporaryDirectory() as folder:
    for shutter in (0.0, 0.5, 1.0):
        STDOUT.write("%g %.3f %.3f\n" % (shutter, *widths(shutter, os.path.join(folder, "frame.png"))))
leave(0)
