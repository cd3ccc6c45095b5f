#!/usr/bin/python3
"""Compares a frame with OpenVDB's own mesh to volume: usage compare_with_openvdb.py MESH.ply FRAME.vdb (text PLY of
triangles). OpenVDB keeps faces that lie inside, so distances may differ there; the surface must be the same one."""
import sys

import numpy as np
import pyopenvdb as vdb


def read_ply(path):
    lines = open(path).read().split("\n")
    body = lines.index("end_header") + 1
    count = {line.split()[1]: int(line.split()[2]) for line in lines[:body] if line.startswith("element")}
    rows = [line.split() for line in lines[body:]]
    points = np.array([[float(v) for v in row[:3]] for row in rows[: count["vertex"]]], np.float32)
    faces = rows[count["vertex"] : count["vertex"] + count["face"]]
    return points, np.array([[int(v) for v in row[1:4]] for row in faces], np.uint32)


points, triangles = read_ply(sys.argv[1])
ours = vdb.read(sys.argv[2], "surface")
voxel = ours.transform.voxelSize()[0]
theirs = vdb.FloatGrid.createLevelSetFromPolygons(
    points, triangles=triangles, transform=ours.transform, halfWidth=3.0
)
(low, high), (their_low, their_high) = ours.evalActiveVoxelBoundingBox(), theirs.evalActiveVoxelBoundingBox()
assert max(np.abs(np.subtract(low, their_low)).max(), np.abs(np.subtract(high, their_high)).max()) <= 1, "boxes differ"
arrays = []
for grid in ours, theirs:
    array = np.empty([b - a + 1 for a, b in zip(low, high)], np.float32)
    grid.copyToArray(array, ijk=low)
    arrays.append(array / voxel)
a, b = arrays
outside = (a > 0) & (a < 3)
assert np.abs(a - b)[outside].mean() < 0.05, f"distances differ by {np.abs(a - b)[outside].mean()} voxel"
apart = ((a < 0) != (b < 0)) & (np.abs(a - b) > 1)
assert apart.sum() < 1e-3 * outside.sum(), f"{apart.sum()} voxels are on different sides"
volumes = [np.clip(0.5 - array, 0, 1).sum() for array in arrays]
assert abs(volumes[0] / volumes[1] - 1) < 0.01, f"volumes {volumes}"
