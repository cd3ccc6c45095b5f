#!/usr/bin/env python3
"""Makes docs/performance.md from docs/performance.in.md and the logs of the benches, each of one run.

    scripts/performance.py LOG... >page
"""

import collections
import pathlib
import re
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# The number of a goal: what, the bench, and what a hand-written bound for that job alone reached.
GOALS = {
    "1": ("leaves opened ÷ leaves that hold a piece of the band", "band", "1.15–1.18"),
    "2": ("evaluation of the whole tape, share of the rate of vector square roots", "evaluate", "0.42–0.44"),
    "3": ("the same, rate against fidget's JIT with R₀", "evaluate", "0.94 at AVX2, 1.9 at AVX-512"),
    "4": ("finding leaves and filling F, rate against fidget's JIT with min and max", "leaves", "22"),
    "4-apart": ("the same, leaves found first and entered again to be filled, as the program does", "leaves", ""),
    "5": ("sparse distances from the scene's text on, rate against the loop with an accessor", "sparse", "190"),
    "6": ("sparse distances, share of the time of `createLevelSetSphere` and CSG", "sparse", "0.4"),
    "7": ("time at twice the resolution", "band", "3.6–3.7"),
    "8": ("peak memory less 30 MB, in bytes of the leaves of one float grid", "band", ""),
    "9": ("distances, rate against `levelSetRebuild`", "redistance", "200"),
    "10": ("distances, rate against `sdfToSdf`", "redistance", "700"),
    "11": ("blocks across the bridge and encoded, rate against C++ alone, which links leaves and encodes them", "handover", "1"),
    "11-voxels": ("the same, not compressed, against a call a voxel", "handover", ""),
    "12": ("a frame with colour, computed and on the disk, share of the time of `io::File`", "frames", "0.95"),
    "13": ("a frame of a sequence of them, the same", "frames", "0.6"),
    "14": ("a frame of a morph in memory, rate against `LevelSetMorphing`", "morphing", "100"),
    "14-written": ("the same with colour, on the disk", "morphing", ""),
    "14-whole": ("the same with its share of making the morph ready", "morphing", ""),
    "18": ("two threads against one, computing", "band", "1.9–2.0"),
    "18-machine": ("two threads against one, arithmetic in registers in turns with row 18", "band", "2"),
    "18-memory": ("the same, reading and writing memory beyond a core's cache", "band", ""),
    "18-handover": ("two threads against one, handing over and encoding", "handover", ""),
    "mesh-voxels": ("a mesh's file of 102,400 triangles to a coloured band, rate against `meshToVolume` with colours", "meshes", ""),
    "mesh-voxels-ready": ("the same, the mesh read", "meshes", ""),
    "polygons": ("a coloured frame to polygons' bytes, rate against `volumeToMesh` and colours", "meshes", ""),
    "polygons-merged": ("the same with `--adaptivity 0.1`, against its adaptivity 0.01", "meshes", ""),
    "written": ("a ready frame with colour on the disk, rate against `io::File`", "handover", ""),
}
STAGES = ["find", "fill", "distances", "colour", "encode", "check", "disk"]
BOUND = ["points, millions", "distances", "gradients alone", "of that in the caches"]
BOUND_COLOUR = ["voxels, millions", "colours", "sampling in the caches"]
MISSING = "Not in the logs that this page was made from."
PROGRAM = {
    "cubism-256": ("`hfvdb bake cubism -o out/m.####.vdb`: 48 frames at 256 with colour", "90 s; 2 GiB"),
    "cubism-1024": ("`hfvdb bake cubism --resolution 1024 --frames 24 -o m.vdb`", "8 GiB"),
}


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def words(command):
    return subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT).stdout.strip()


def machine():
    lscpu = dict(re.findall(r"^(.+?):\s+(.+)$", words(["lscpu"]), re.M))
    memory = int(re.search(r"MemTotal:\s+(\d+)", pathlib.Path("/proc/meminfo").read_text()).group(1)) / 2**20
    wide = "AVX-512" if "avx512_vbmi2" in lscpu.get("Flags", "") else "AVX2" if "avx2" in lscpu.get("Flags", "") else "SSE2"
    system = re.search(r'PRETTY_NAME="(.+)"', pathlib.Path("/etc/os-release").read_text()).group(1)
    header = pathlib.Path("/usr/include/openvdb/version.h").read_text()
    openvdb = ".".join(re.findall(r"OPENVDB_LIBRARY_(?:MAJOR|MINOR|PATCH)_VERSION_NUMBER (\d+)", header)[:3])
    rust = words(["rustc", "--version"]).split()[1]
    commit = words(["git", "rev-parse", "--short", "HEAD"])
    changed = " with changes" if words(["git", "status", "--porcelain", "--", "src", "cpp", "bench", "Cargo.lock"]) else ""
    return (
        f"Machine: {lscpu['CPU(s)']} cores with {wide} ({lscpu['Model name']}), {memory:.0f} GiB, {system}, "
        f"OpenVDB {openvdb}, Rust {rust}; commit {commit}{changed}."
    )


def number(value):
    return f"{value:.1e}" if 0 < abs(value) < 0.01 else f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def reached(goal, values):
    """The values, in bold where the middle one misses the goal."""
    text = ", ".join(number(value) for value in values)
    sign, _, limit = goal.partition(" ")
    if not limit:
        return text
    middle = statistics.median(values)
    missed = middle < float(limit) if sign == "≥" else middle > float(limit)
    return f"**{text}**" if missed else text


def read(logs):
    """Rows by what they measure, a value a run; and the fields of all other lines by their first word."""
    rows, others = {}, collections.defaultdict(list)
    for log in logs:
        for line in pathlib.Path(log).read_text().splitlines():
            kind, *fields = line.split() or [""]
            if kind == "ROW":
                key = tuple(fields[:4])
                rows.setdefault(key, (line.partition(" goal ")[2], []))[1].append(float(fields[4]))
            elif kind == "MACHINE":
                others[kind].append(" ".join(fields))
            elif kind in ("STAGE", "BOUND", "BOUND-COLOUR", "GROWTH", "EXPONENT", "PROGRAM", "MEMORY"):
                others[kind].append(fields)
    return rows, others


def goals(rows):
    lines = []
    order = list(GOALS)
    for (name, scene, resolution, what), (goal, values) in sorted(rows.items(), key=lambda row: order.index(row[0][0])):
        if what == "processor" or ":_" in what:
            continue
        job, bench, floor = GOALS[name]
        processor = rows.get((name, scene, resolution, "processor"), (goal, []))[1] if what == "clock" and not name.startswith("18") else []
        where = f"{scene} {resolution}" if what in ("clock", "leaves", "memory") else f"{scene}, {what}"
        lines.append([
            name.partition("-")[0] if name[0].isdigit() else "", job, where.replace(",_", ", ").replace(":_", ": "), floor,
            goal.replace("-", ""), reached(goal, values), reached(goal, processor) if processor else "", f"`{bench}`",
        ])
    return table(["#", "job", "scene, voxels", "floor", "goal", "reached", "processor time", "bench"], lines)


def errors(rows):
    found = collections.defaultdict(dict)
    for (name, scene, resolution, what), (_, values) in rows.items():
        who, colon, error = what.partition(":_")
        if colon:
            found[scene, resolution, who.replace("_", " ")][error] = number(statistics.median(values))
    lines = [
        [f"{scene} {resolution}", who, *(all.get(error, "") for error in ("mean", "greatest", "wrong_signs"))]
        for (scene, resolution, who), all in found.items()
    ]
    return table(["scene, voxels", "by", "mean", "greatest", "wrong signs"], lines)


def stages(lines):
    found = collections.defaultdict(lambda: collections.defaultdict(list))
    for scene, resolution, stage, clock, processor in lines:
        found[f"{scene} {resolution}, clock"][stage].append(float(clock))
        found[f"{scene} {resolution}, processor"][stage].append(float(processor))
    rows = []
    for scene, all in found.items():
        medians = [statistics.median(all[stage]) for stage in STAGES]
        rows.append([scene, *(f"{median:.0f}" for median in medians), f"{sum(medians):.0f}"])
    return table(["scene, voxels", *(stage.replace("_", " ") for stage in STAGES), "all"], rows)


def bound(lines, what):
    """The medians of a line's numbers, by scene; `what` names them."""
    found = collections.defaultdict(list)
    for scene, resolution, *numbers in lines:
        found[f"{scene} {resolution}"].append([float(number) for number in numbers])
    rows = [[scene, *(number(statistics.median(column)) for column in zip(*all))] for scene, all in found.items()]
    return table(["scene, voxels", *what, "ratio"], rows)


def growth(lines, exponents):
    head = ["scene, voxels", "active voxels", "made ready", "compute", "write", "memory", "file"]
    rows = []
    for scene, resolution, voxels, ready, compute, write, memory, size in lines:
        megabytes = [f"{float(value) / 1e6:.1f} MB" for value in (memory, size)]
        rows.append([f"{scene} {resolution}", voxels, f"{ready} s", f"{compute} s", f"{write} s", *megabytes])
    rows.extend([f"{scene}, exponent", "", "", *values] for scene, *values in exponents)
    return table(head, rows)


def program(lines):
    rows = [
        [PROGRAM[name][0], f"{clock} s", f"{processor} s", f"{int(peak) / 2**20:.0f} MiB", PROGRAM[name][1]]
        for name, clock, processor, peak in lines
    ]
    return table(["command", "time", "processor time", "peak memory", "goal"], rows)


def memory(lines):
    head = ["command, MiB in each tenth of its time", *(f"{tenth}" for tenth in range(1, 11))]
    return table(head, [[PROGRAM[name][0], *(f"{int(most) / 2**20:.0f}" for most in tenths)] for name, *tenths in lines])


def main():
    # Written into the logs as they begin: the page may be made again when the program has gone on.
    if sys.argv[1:] == ["--machine"]:
        print("MACHINE", machine())
        return
    rows, others = read(sys.argv[1:])
    if not rows or not others["MACHINE"]:
        sys.exit("performance: no logs; run scripts/performance.sh without arguments")
    page = (ROOT / "docs/performance.in.md").read_text()
    parts = {
        "machine": "\n".join(sorted(set(others["MACHINE"]))),
        "goals": goals(rows),
        "errors": errors(rows),
        "runs": {1: "one run", 3: "three runs"}.get(len(sys.argv) - 1, f"{len(sys.argv) - 1} runs"),
        "stages": stages(others["STAGE"]) if others["STAGE"] else MISSING,
        "bound": bound(others["BOUND"], BOUND) if others["BOUND"] else MISSING,
        "bound_colour": bound(others["BOUND-COLOUR"], BOUND_COLOUR) if others["BOUND-COLOUR"] else MISSING,
        "growth": growth(others["GROWTH"], others["EXPONENT"]) if others["GROWTH"] else MISSING,
        "program": program(others["PROGRAM"]) if others["PROGRAM"] else MISSING,
        "memory": memory(others["MEMORY"]) if others["MEMORY"] else MISSING,
    }
    for name, text in parts.items():
        page = page.replace("{" + name + "}", text)
    print(page, end="")


if __name__ == "__main__":
    main()
