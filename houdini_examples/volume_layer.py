"""A USD layer with a sequence of .vdb files as one Volume: what Solaris and other programs of USD take.

Knows USD (`pxr`) alone: tried with usd-core 26.11, without Houdini.
"""
from __future__ import annotations

import os
import struct

from pxr import Gf, Sdf, Usd, UsdGeom, UsdVol

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
# Classes and types as OpenVDB spells them, and as USD does. A wrong token draws no message.
CLASSES = {"level set": "levelSet", "fog volume": "fogVolume", "staggered": "staggered"}
TYPES = {"float": "float", "vec3s": "float3", "double": "double", "vec3d": "double3"}
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0, "in": 0.0254, "ft": 0.3048}


def metres_per_unit(path: str) -> float:
    """What the metadata of a .vdb file, `hfvdb_unit`, say that 1 stands for; 1 metre where they say nothing."""
    # Read here: neither USD nor Houdini gives the metadata of the file itself, but those of its grids alone.
    with open(path, "rb") as file:
        magic, version = struct.unpack("<qI", file.read(12))
        if magic != 0x56444220 or version < 222:
            return 1.0
        file.seek(9 + 36, os.SEEK_CUR)  # the library's version, whether grids have offsets, the file's identifier

        def text() -> bytes:
            return file.read(struct.unpack("<I", file.read(4))[0])

        for _ in range(struct.unpack("<I", file.read(4))[0]):
            name, _kind, value = text(), text(), text()
            if name == b"hfvdb_unit":
                return METRES.get(value.decode("utf-8", "replace"), 1.0)
    return 1.0


def write(
    layer: str,
    files: dict[int, str],
    boxes: dict[int, Box],
    grids: dict[str, tuple[str, str]],
    rate: float = 24.0,
    up: str = "Z",
) -> str:
    """Writes the layer, and returns the Volume's path. `files` and their `boxes` by frame, class and type of `grids` by
    name. Paths in it are relative to it."""
    stage = Usd.Stage.CreateNew(layer)
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, metres_per_unit(files[min(files)]))
    stage.SetTimeCodesPerSecond(rate)
    stage.SetFramesPerSecond(rate)
    stage.SetStartTimeCode(min(files))
    stage.SetEndTimeCode(max(files))
    root = UsdGeom.Xform.Define(stage, "/hfvdb")
    stage.SetDefaultPrim(root.GetPrim())
    volume = UsdVol.Volume.Define(stage, "/hfvdb/volume")
    # Of files it is not computed, and without it nothing may be drawn.
    extent = volume.CreateExtentAttr()
    for frame, (low, high) in sorted(boxes.items()):
        extent.Set([Gf.Vec3f(*low), Gf.Vec3f(*high)], frame)
    folder = os.path.dirname(os.path.abspath(layer))
    for name, (grid_class, kind) in grids.items():
        if kind not in TYPES:
            continue
        asset = UsdVol.OpenVDBAsset.Define(stage, volume.GetPath().AppendChild(name))
        asset.CreateFieldNameAttr(name)
        asset.CreateFieldIndexAttr(0)
        asset.CreateFieldDataTypeAttr(TYPES[kind])
        asset.CreateFieldClassAttr(CLASSES.get(grid_class, "unknown"))
        if kind.startswith("vec3"):
            asset.CreateVectorDataRoleHintAttr("Vector" if name in ("v", "vel", "velocity") else "Color")
        path = asset.CreateFilePathAttr()
        for frame, file in sorted(files.items()):
            path.Set(Sdf.AssetPath("./" + os.path.relpath(os.path.abspath(file), folder)), frame)
        # Shaders find the grid by this name.
        volume.CreateFieldRelationship(name, asset.GetPath())
    stage.GetRootLayer().Save()
    return str(volume.GetPath())
