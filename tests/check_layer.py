"""Reads a USD layer of .vdb files as Pixar's library does and as Blender does, and prints what each found as JSON."""
import json
import sys

import bpy

bpy.utils.expose_bundled_modules()
from pxr import Usd, UsdGeom, UsdUtils, UsdVol  # noqa: E402

path = sys.argv[1]
stage = Usd.Stage.Open(path)
checker = UsdUtils.ComplianceChecker()
checker.CheckCompliance(path)
volume = UsdVol.Volume(next(prim for prim in stage.Traverse() if prim.IsA(UsdVol.Volume)))
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
found = {
    "wrong": checker.GetErrors() + checker.GetFailedChecks(),
    "up": UsdGeom.GetStageUpAxis(stage),
    "metres": UsdGeom.GetStageMetersPerUnit(stage),
    "fps": stage.GetTimeCodesPerSecond(),
    "shot": [stage.GetStartTimeCode(), stage.GetEndTimeCode()],
    "times": times,
    "extent": [list(corner) for corner in extent],
    "fields": {name: field(name) for name in volume.GetFieldPaths()},
}
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=path)
volumes = [item for item in bpy.data.objects if item.type == "VOLUME"]
data = volumes[0].data
data.grids.load()
found["blender"] = {
    "volumes": len(volumes),
    "sequence": data.is_sequence,
    "frames": [data.frame_start, data.frame_duration],
    "grids": [grid.name for grid in data.grids],
    "scene": [bpy.context.scene.frame_start, bpy.context.scene.frame_end],
}
print("found " + json.dumps(found))
