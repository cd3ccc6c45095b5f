#!/usr/bin/python3
"""Reads a .vdb with Debian's Python OpenVDB and says what is in it, for tests that compare with exact values.

    dump_grids.py FILE FOLDER [X0,Y0,Z0,X1,Y1,Z1]

stdout: JSON of the file's metadata and of each grid's class (by name), background, transform, counts and metadata. With a box
(its last voxel included), FOLDER gets NAME.values and NAME.active: the grid's voxels in the box, z fastest, as
little-endian 32-bit floats and as bytes of 0 and 1. FOLDER also gets again.vdb, the same grids as OpenVDB's own
writer stores them.
"""
import json
import os
import sys

import numpy as np
import pyopenvdb as vdb


def plain(value):
    return list(value) if isinstance(value, tuple) else value


def dump(grid, folder, low, high):
    shape = [h - l + 1 for l, h in zip(low, high)]
    values = np.zeros(shape + ([3] if grid.valueTypeName == "vec3s" else []), np.float32)
    grid.copyToArray(values, ijk=low)
    active = np.zeros(shape, np.uint8)
    for item in grid.iterOnValues():
        first = [max(i, l) - l for i, l in zip(item.min, low)]
        last = [min(i, h) - l + 1 for i, h, l in zip(item.max, high, low)]
        active[first[0]:last[0], first[1]:last[1], first[2]:last[2]] = 1
    values.astype("<f4").tofile(os.path.join(folder, grid.name + ".values"))
    active.tofile(os.path.join(folder, grid.name + ".active"))


def describe(grid):
    return {
        "name": grid.name,
        "type": grid.valueTypeName,
        "class": str(grid.metadata.get("class", "unknown")),
        "vector_type": grid.metadata.get("vector_type"),
        "half": grid.saveFloatAsHalf,
        "background": plain(grid.background),
        "voxel_size": plain(grid.transform.voxelSize()),
        "origin": plain(grid.transform.indexToWorld((0, 0, 0))),
        "active": grid.activeVoxelCount(),
        "leaves": grid.leafCount(),
        "metadata": {key: plain(value) for key, value in grid.metadata.items()},
    }


def main():
    path, folder = sys.argv[1:3]
    grids, metadata = vdb.readAll(path)
    if len(sys.argv) > 3:
        box = [int(number) for number in sys.argv[3].split(",")]
        for grid in grids:
            dump(grid, folder, tuple(box[:3]), tuple(box[3:]))
    # The statistics are the writer's to make, also the second time.
    copies = [grid.deepCopy() for grid in grids]
    vdb.write(os.path.join(folder, "again.vdb"), grids=copies, metadata=metadata)
    print(json.dumps({"metadata": metadata, "grids": {grid.name: describe(grid) for grid in grids}}))


if __name__ == "__main__":
    main()
