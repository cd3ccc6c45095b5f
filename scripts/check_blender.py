#!/usr/bin/env python3
"""Opens .vdb files in real Blender and says what an artist would get.

    python check_blender.py FILE.vdb [FILE.vdb ...] [options]

Needs a Python that has Blender as a module (`pip install bpy`, tried with 5.0.1). The files go through the node
graph that a user would build: Get Named Grid, Grid to Mesh at threshold 0, and the colour grid sampled at the
vertices into a colour attribute.

Problems are reported, and end the run with exit code 1, when
  * the file or one of its grids does not load, or a grid is of the wrong type;
  * the mesh is empty, not closed, not oriented alike everywhere, or inside out;
  * a voxel's length inside and outside of a vertex the field is neither a voxel's length nor, where walls and gaps are
    thinner than that, the distance to the mesh: wrong sign, wrong units;
  * there is a second surface: a piece of the mesh where the field does not pass through 0 but leaps over it, which is
    the inner edge of a band whose inside was not filled. (A hollow in the solid is none: the field is a distance there.)
  * with --pieces N: the solid is in more than N pieces (crumbs);
  * colours are missing (most vertices black), not finite, or outside [0, 1];
  * with --sequence: frame n does not play file n.

stdout is one JSON document; --dump writes what it was computed from, to be compared with exact values.
"""
import argparse
import json
import os
import sys

from blender_scene import STDOUT, Player, bpy, coloured_mesh, last_number, leave, new_object, np, read_mesh

from mathutils.bvhtree import BVHTree  # a part of Blender: there once bpy is

# How far the field may be from a voxel's length one voxel off the surface, in voxels: near creases it is shorter. Where
# it is farther from that, another part of the surface may be nearer, and it is held against the distance to the mesh.
FIELD_TOLERANCE = 0.5
# The fraction of vertices that has to hold it.
FIELD_FRACTION = 0.9
# No distance changes by more than a voxel over a voxel; a field that does, by this many voxels, leaps. At the inner
# edge of an unfilled band it goes from one end of its range to the other: 1.5 voxels and more on either side.
LEAP = 1.4


def arguments():
    parser = argparse.ArgumentParser(description="check .vdb files in Blender")
    parser.add_argument("files", nargs="+", help=".vdb files; with --sequence the frames, in order")
    parser.add_argument("--surface", default="surface", help="the level set's name")
    parser.add_argument("--colour", default="Cd", help="the colour grid's name, or 'none'")
    parser.add_argument("--sequence", action="store_true", help="load the files as one sequence and play it")
    parser.add_argument("--pieces", type=int, metavar="N", help="the most pieces that the solid may be in")
    parser.add_argument("--dump", metavar="FOLDER", help="write NAME.positions.f32 and NAME.colours.f32: of each "
                        "vertex three little-endian 32-bit floats, in world units and linear RGB")
    return parser.parse_args()


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


def directed_edges(corners, sizes):
    ends = np.cumsum(sizes)
    following = np.arange(1, len(corners) + 1)
    following[ends - 1] = ends - sizes
    return np.stack([corners, corners[following]], 1).astype(np.int64)


def pieces_of(count, edges):
    """The number of the connected piece of each vertex, by spreading the least vertex number along the edges."""
    label = np.arange(count)
    while True:
        before = label.copy()
        np.minimum.at(label, edges[:, 0], label[edges[:, 1]])
        np.minimum.at(label, edges[:, 1], label[edges[:, 0]])
        label = label[label]
        if (label == before).all():
            return np.unique(label, return_inverse=True)[1]


def signed_volumes(positions, corners, sizes, piece):
    """Of each piece: positive where normals point outwards, negative around a hollow."""
    points = positions - positions.mean(0)
    starts = np.cumsum(sizes) - sizes
    volumes = np.zeros(piece.max() + 1)
    for step in range(1, int(sizes.max()) - 1):
        faces = starts[sizes > step + 1]
        a, b, c = (points[corners[faces + offset]] for offset in (0, step, step + 1))
        volumes += np.bincount(piece[corners[faces]], (a * np.cross(b, c)).sum(1) / 6, len(volumes))
    return volumes


def check_mesh(mesh, colour, voxel, most_pieces, problems):
    positions, corners, sizes = mesh["positions"], mesh["corners"], mesh["sizes"]
    facts = {"vertices": len(positions), "faces": len(sizes)}
    if len(sizes) == 0:
        problems.append("there is no mesh")
        return facts
    edges = directed_edges(corners, sizes)
    width = len(positions) + 1
    key, twin = edges[:, 0] * width + edges[:, 1], edges[:, 1] * width + edges[:, 0]
    facts["closed"] = bool(np.isin(key, twin).all())
    if not facts["closed"]:
        problems.append("the mesh is open, or its faces are not oriented alike")
    piece = pieces_of(len(positions), edges)
    volumes = signed_volumes(positions, corners, sizes, piece)
    facts["pieces"], facts["hollows"] = int((volumes > 0).sum()), int((volumes < 0).sum())
    facts["signed_volume"] = float(volumes.sum())
    facts["box"] = [positions.min(0).tolist(), positions.max(0).tolist()]
    if facts["signed_volume"] <= 0:
        problems.append("the mesh is inside out: wrong sign or wrong class")
    if most_pieces is not None and facts["pieces"] > most_pieces:
        small = sorted(volumes[volumes > 0])[:-most_pieces]
        problems.append("%d pieces instead of %d; the small ones have volumes up to %.3g voxels" % (
            facts["pieces"], most_pieces, max(small) / voxel ** 3))
    inside, outside = mesh["inside"] / voxel, mesh["outside"] / voxel
    error = np.maximum(abs(inside + 1), abs(outside - 1))
    good = error < FIELD_TOLERANCE
    facts["field_error_mean"] = float(error.mean())
    if good.mean() < FIELD_FRACTION:
        good[~good] = is_distance(mesh, np.flatnonzero(~good), voxel)
    facts["field_good"] = float(good.mean())
    if facts["field_good"] < FIELD_FRACTION:
        problems.append("the field is no distance beside %.1f %% of the vertices" % (100 * (1 - facts["field_good"])))
    leaps = np.bincount(piece, np.maximum(abs(inside), abs(outside)) > LEAP, len(volumes)) / np.bincount(piece)
    for second in np.flatnonzero(leaps > 0.5):
        problems.append("a second surface of %d vertices, where the field leaps: the band's inside is not filled, or the units are wrong" % (
            (piece == second).sum()))
    if colour:
        facts["colour"] = check_colour(mesh.get(colour), problems)
    return facts


def is_distance(mesh, vertices, voxel):
    """Whether the field beside each of some vertices is the distance to the mesh: a wall or a gap may be thin there."""
    positions, ends = mesh["positions"], np.cumsum(mesh["sizes"])
    polygons = [face.tolist() for face in np.split(mesh["corners"], ends[:-1])]
    tree = BVHTree.FromPolygons(positions.tolist(), polygons)
    good = np.ones(len(vertices), bool)
    for name, sign in (("inside", -1.0), ("outside", 1.0)):
        probes = positions[vertices] + sign * voxel * mesh["normals"][vertices]
        distances = np.array([tree.find_nearest(probe)[3] for probe in probes.tolist()])
        good &= abs(abs(mesh[name][vertices]) - distances) < FIELD_TOLERANCE * voxel
    return good


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


def dump(folder, path, mesh, colour):
    os.makedirs(folder, exist_ok=True)
    stem = os.path.join(folder, os.path.splitext(os.path.basename(path))[0])
    mesh["positions"].astype("<f4").tofile(stem + ".positions.f32")
    if colour in mesh:
        mesh[colour].astype("<f4").tofile(stem + ".colours.f32")


def main(options):
    colour = None if options.colour == "none" else options.colour
    wanted = [(options.surface, "FLOAT")] + ([(colour, "VECTOR_FLOAT")] if colour else [])
    report = {"blender": bpy.app.version_string, "frames": []}
    player = Player(options.files, options.sequence)
    carrier = new_object("mesh", bpy.data.meshes.new("mesh"))
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
            modifier.node_group = coloured_mesh(player.object, options.surface, colour, probe=voxel)
            graph_voxel = voxel
        playing = player.show(index)
        if os.path.abspath(bpy.path.abspath(playing)) != path:
            problems.append("Blender plays '%s' instead" % playing)
        mesh = read_mesh(carrier)
        frame["mesh"] = check_mesh(mesh, colour, voxel, options.pieces, problems)
        if options.dump:
            dump(options.dump, path, mesh, colour)
    report["problems"] = [os.path.basename(f["file"]) + ": " + text for f in report["frames"] for text in f["problems"]]
    return report


if __name__ == "__main__":
    OPTIONS = arguments()
    if OPTIONS.sequence and any(last_number(path) is None for path in OPTIONS.files):
        sys.exit("a sequence needs file names that end in a number before .vdb")
    REPORT = main(OPTIONS)
    STDOUT.write(json.dumps(REPORT, indent=1) + "\n")
    leave(1 if REPORT["problems"] else 0)
