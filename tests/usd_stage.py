"""Opens a USD file as Pixar's library does and as Blender does, and says what is so of any."""
import json

import bpy

bpy.utils.expose_bundled_modules()
from pxr import Usd, UsdGeom, UsdUtils  # noqa: E402


def opened(path, kind):
    """The stage, its first prim of a kind, and what was found of the whole."""
    stage = Usd.Stage.Open(path)
    checker = UsdUtils.ComplianceChecker()
    checker.CheckCompliance(path)
    found = {
        "wrong": checker.GetErrors() + checker.GetFailedChecks(),
        "up": UsdGeom.GetStageUpAxis(stage),
        "metres": UsdGeom.GetStageMetersPerUnit(stage),
        "fps": stage.GetTimeCodesPerSecond(),
        "shot": [stage.GetStartTimeCode(), stage.GetEndTimeCode()],
    }
    return stage, kind(next(prim for prim in stage.Traverse() if prim.IsA(kind))), found


def in_blender(path, kind):
    """Blender's objects of a kind."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=path)
    return [item for item in bpy.data.objects if item.type == kind]


def tell(found):
    print("found " + json.dumps(found))
