"""Reads a USD layer of .vdb files as Pixar's library does and as Blender does, and prints what each found as JSON."""
import sys

import bpy

from usd_stage import in_blender, opened, tell
from pxr import Usd, UsdVol  # noqa: E402

path = sys.argv[1]
stage, volume, found = opened(path, UsdVol.Volume)
times = [int(time) for time in volume.GetExtentAttr().GetTimeSamples()]


def field(name):
    asset = UsdVol.OpenVDBAsset(stage.GetPrimAtPath(volume.GetFieldPath(name)))
    at = asset.GetFilePathAttr()
    return {
        "name": asset.GetFieldNameAttr().Get(),
        "type": asset.GetFieldDataTypeAttr().Get(),
        "class": asset.GetFieldClassAttr().Get(),
        "role": asset.GetVectorDataRoleHintAttr().Get(),
        "files": [at.Get(time).resolvedPath for time in at.GetTimeSamples() or [Usd.TimeCode.Default()]],
    }


extent = volume.GetExtentAttr().Get(times[-1] if times else Usd.TimeCode.Default())
found |= {
    "times": times,
    "extent": [list(corner) for corner in extent],
    "fields": {name: field(name) for name in volume.GetFieldPaths()},
}
volumes = in_blender(path, "VOLUME")
data = volumes[0].data
data.grids.load()
found["blender"] = {
    "volumes": len(volumes),
    "sequence": data.is_sequence,
    "frames": [data.frame_start, data.frame_duration],
    "grids": [grid.name for grid in data.grids],
    "scene": [bpy.context.scene.frame_start, bpy.context.scene.frame_end],
}
tell(found)
