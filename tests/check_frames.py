#!/usr/bin/python3
"""Checks frames with Debian's Python OpenVDB: usage check_frames.py FILE..., one line a frame, exit code 1 on any problem.

Checked in each file: the grids and their classes, value types and metadata; one transform and one topology; the
background; and over the dense box around the band that the values are those of one narrow-band distance field:

* neighbouring voxels never differ by more than a voxel (true of every distance field, clamped or not), within what is
  promised of their exactness. A wrong sign, an unfilled inside or a second surface breaks this;
* |grad| is 1 to 0.01, by central differences, for a quarter of the voxels with all neighbours in the band: where facets
  are four voxels wide, the others have a crease of the distance between those neighbours;
* colours are finite and inside [0, 1], and the colour's background is their mean;
* other float grids are finite, on the same voxels, and their background is their mean;
* velocities are where the surface is, further outside or not, and nowhere inside of the band.
"""
import multiprocessing
import sys

import numpy as np
import pyopenvdb as vdb

# Two distances that are each within the promised 0.05 voxel differ by this at most.
STEP = 1.1
# Files looked at side by side, at most: each takes some hundred megabytes.
PROCESSES = 4


def dense(grid, low, high, kind):
    shape = [h - l + 1 for l, h in zip(low, high)]
    array = np.empty(shape + [3] if kind == "vec3s" else shape, np.float32)
    grid.copyToArray(array, ijk=low)
    return array


def active_mask(grid, low, high):
    """Where a grid is active. Mapping its values is ten times as fast as going through them one by one."""
    kind = grid.valueTypeName
    on, off = ((1.0,) * 3, (0.0,) * 3) if kind == "vec3s" else (1.0, 0.0)
    mask = grid.deepCopy()
    mask.background = off
    mask.mapOn(lambda _: on)
    mask.mapOff(lambda _: off)
    values = dense(mask, low, high, kind)
    return (values[..., 0] if kind == "vec3s" else values) == 1


def check(path):
    """What is to be said of a file, and whether it is good."""
    problems = []

    def must(condition, text):
        if not condition:
            problems.append(text)

    grids, metadata = vdb.readAll(path)
    by_name = {grid.name: grid for grid in grids}
    must(len(by_name) == len(grids), "two grids of one name")
    must("surface" in by_name, "no grid 'surface'")
    for key in ("creator", "hfvdb_scene", "hfvdb_frame"):
        must(key in metadata, "no metadata '%s'" % key)
    surface = by_name["surface"]
    voxel = surface.transform.voxelSize()[0]
    background = surface.background
    must(surface.gridClass == vdb.GridClass.LEVEL_SET, "surface is no level set")
    must(background > 0 and background / voxel >= 1.5, "background %g for voxels of %g" % (background, voxel))
    for key in ("file_bbox_min", "file_bbox_max", "file_voxel_count", "file_mem_bytes"):
        must(key in surface.metadata, "no statistics '%s'" % key)
    must(surface.metadata.get("file_voxel_count") == surface.activeVoxelCount(), "file_voxel_count is wrong")

    low, high = surface.evalActiveVoxelBoundingBox()
    low = tuple(l - 2 for l in low)
    high = tuple(h + 2 for h in high)
    values = dense(surface, low, high, "float")
    must(np.isfinite(values).all(), "values that are not finite")
    must(abs(values).max() <= background * (1 + 1e-6), "values beyond the background")
    must((values[0] > 0).all() and (values[-1] > 0).all(), "solid at the border of the box")
    must(values.min() < 0, "nothing inside")
    for axis in range(3):
        step = (abs(np.diff(values, axis=axis)) / voxel).max()
        must(step <= STEP, "neighbours along %s differ by %.3f voxels" % ("xyz"[axis], step))

    inner = values[1:-1, 1:-1, 1:-1]
    neighbours = [(values[2:, 1:-1, 1:-1], values[:-2, 1:-1, 1:-1]), (values[1:-1, 2:, 1:-1], values[1:-1, :-2, 1:-1]),
                  (values[1:-1, 1:-1, 2:], values[1:-1, 1:-1, :-2])]
    band = abs(inner) < background
    squares = np.zeros_like(inner)
    for a, b in neighbours:
        band &= (abs(a) < background) & (abs(b) < background)
        squares += ((a - b) / (2 * voxel)) ** 2
    slope = np.sqrt(squares[band])
    must(band.any(), "no voxel has its neighbours in the band")
    error = float(np.quantile(abs(slope - 1), 0.25)) if band.any() else float("nan")
    must(error < 0.01, "|grad| is off by %.4f for most voxels" % error)

    colour = by_name.get("Cd")
    if colour is not None:
        must(colour.valueTypeName == "vec3s", "Cd is %s" % colour.valueTypeName)
        must(colour.vectorType == vdb.VectorType.INVARIANT if hasattr(vdb, "VectorType") else True, "Cd is not invariant")
        must(colour.transform == surface.transform, "two transforms")
        must(colour.activeVoxelCount() == surface.activeVoxelCount(), "two topologies")
        rgb = dense(colour, low, high, "vec3s")
        on = abs(values) < background
        must((active_mask(colour, low, high) == active_mask(surface, low, high)).all(), "two topologies")
        must(np.isfinite(rgb).all(), "colours that are not finite")
        must(rgb.min() >= 0 and rgb.max() <= 1, "colours outside [0, 1]: %g to %g" % (rgb.min(), rgb.max()))
        mean = rgb[on].mean(axis=0, dtype=np.float64)
        must(abs(mean - np.array(colour.background)).max() < 1e-3, "Cd's background is not the mean colour")
    for grid in grids:
        if grid.valueTypeName != "float" or grid.name == "surface":
            continue
        must(grid.gridClass == vdb.GridClass.UNKNOWN, "%s has a class" % grid.name)
        must(grid.transform == surface.transform, "%s: two transforms" % grid.name)
        must((active_mask(grid, low, high) == active_mask(surface, low, high)).all(), "%s: two topologies" % grid.name)
        numbers = dense(grid, low, high, "float")[abs(values) < background]
        must(np.isfinite(numbers).all(), "%s: numbers that are not finite" % grid.name)
        off = abs(numbers.mean(dtype=np.float64) - grid.background)
        must(off <= 1e-3 * abs(numbers).max(), "%s: the background is not the mean" % grid.name)
    velocity = by_name.get("vel")
    if velocity is not None:
        must(velocity.valueTypeName == "vec3s", "vel is %s" % velocity.valueTypeName)
        must(velocity.metadata.get("vector_type") == "contravariant relative", "vel is not contravariant-relative")
        must(velocity.metadata.get("is_local_space") is False, "vel is not in the world's space")
        must(velocity.transform == surface.transform, "vel: two transforms")
        must(tuple(velocity.background) == (0, 0, 0), "vel's background is not 0")
        here = active_mask(velocity, low, high)
        must(here[active_mask(surface, low, high)].all(), "vel is missing at voxels of the surface")
        must(not here[values <= -background].any(), "vel inside of the band")
        must(np.isfinite(dense(velocity, low, high, "vec3s")).all(), "velocities that are not finite")
    # The volume inside, by a step smoothed over one voxel.
    volume = float(np.clip(0.5 - values / voxel, 0, 1).sum() * voxel ** 3)
    said = "%s: %d voxels, volume %.6g, |grad| error %.4f, %s" % (
        path, surface.activeVoxelCount(), volume, error, "; ".join(problems) if problems else "good")
    return said, not problems


if __name__ == "__main__":
    files = sys.argv[1:]
    all_good = bool(files)
    with multiprocessing.Pool(max(1, min(len(files), multiprocessing.cpu_count(), PROCESSES))) as pool:
        for said, good in pool.imap(check, files):
            print(said, flush=True)
            all_good &= good
    sys.exit(0 if all_good else 1)
