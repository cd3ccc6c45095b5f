"""Reads a USD file of polygons as Pixar's library does and as Blender does, and prints what each found as JSON."""
import sys

import bpy
import numpy as np

from usd_stage import in_blender, opened, tell
from pxr import Usd, UsdGeom  # noqa: E402

path = sys.argv[1]
stage, mesh, found = opened(path, UsdGeom.Mesh)
primvars = UsdGeom.PrimvarsAPI(mesh)
times = mesh.GetPointsAttr().GetTimeSamples()


def edges(counts, indices):
    """Edges that are not between two faces that go along them in opposite ways."""
    corners = np.asarray(indices).reshape(-1, 3)
    assert all(count == 3 for count in counts)
    ways = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    there, number = np.unique(ways, axis=0, return_counts=True)
    back = {tuple(way[::-1]) for way in there}
    return int((number > 1).sum()) + sum(tuple(way) not in back for way in there)


def volume(points, indices):
    corners = np.asarray(points, float)[np.asarray(indices).reshape(-1, 3)]
    return float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def sample(time):
    points, indices = mesh.GetPointsAttr().Get(time), mesh.GetFaceVertexIndicesAttr().Get(time)
    points = np.asarray(points, float)
    extent = np.asarray(mesh.GetExtentAttr().Get(time), float)
    velocities = mesh.GetVelocitiesAttr().Get(time)
    values = {primvar.GetPrimvarName(): np.asarray(primvar.Get(time), float) for primvar in primvars.GetPrimvarsWithValues()}
    return {
        "points": len(points),
        "faces": len(mesh.GetFaceVertexCountsAttr().Get(time)),
        "open_edges": edges(mesh.GetFaceVertexCountsAttr().Get(time), indices),
        "volume": volume(points, indices),
        "extent_fits": bool(np.allclose([points.min(0), points.max(0)], extent)),
        "sizes": {name: len(value) for name, value in values.items()},
        "means": {name: value.mean(0).tolist() for name, value in values.items()},
        "velocity": None if velocities is None else np.asarray(velocities, float).mean(0).tolist(),
    }


found |= {
    "times": [int(time) for time in times],
    "primvars": {primvar.GetPrimvarName(): [str(primvar.GetTypeName()), primvar.GetInterpolation()]
                 for primvar in primvars.GetPrimvarsWithValues()},
    "samples": [sample(time) for time in times or [Usd.TimeCode.Default()]],
}
item = in_blender(path, "MESH")[0]
found["blender"] = []
for time in [int(time) for time in times] or [1]:
    bpy.context.scene.frame_set(time)
    data = item.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    colours = data.color_attributes.get("displayColor")
    values = np.zeros(4 * len(colours.data) if colours else 0, np.float32)
    if colours:
        colours.data.foreach_get("color", values)
    found["blender"].append({
        "points": len(data.vertices),
        "faces": len(data.polygons),
        "colour": values.reshape(-1, 4)[:, :3].mean(0).tolist() if colours else None,
        "attributes": sorted(data.attributes.keys()),
    })
tell(found)
