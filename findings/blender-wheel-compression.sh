#!/usr/bin/env bash
# Blender from PyPI exports glTF without the compression that was asked for, and says that it has succeeded.
#
# Version: bpy 5.2.3 for Linux x86-64 from PyPI (needs Python 3.13).
# Behaviour: the wheel has no libraries for Draco and meshopt. With export_draco_mesh_compression_enable=True, the exporter
#   prints a line "ERROR Draco is not available …" on its console when the add-on is loaded, but then writes the file
#   without compression and returns {'FINISHED'}. The file names no extension, so readers cannot tell either.
# Why it matters: a script that makes test files for a reader of Draco gets plain files, and every test of it passes.
# Seen (November 2026):
#   plain: {'FINISHED'}, extensions []
#   draco: {'FINISHED'}, extensions []
#   same size: True
# The script exits with 1 if that changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3.13}" -m venv "$work/venv"
"$work/venv/bin/pip" install -q bpy==5.2.3
cat >"$work/export.py" <<'PY'
import json, os, sys
import bpy

sizes = []
for name, asked in ("plain", False), ("draco", True):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5)
    path = f"{sys.argv[1]}/{name}.gltf"
    result = bpy.ops.export_scene.gltf(
        filepath=path, export_format="GLTF_SEPARATE", export_draco_mesh_compression_enable=asked)
    with open(path) as file:
        document = json.load(file)
    used = document.get("extensionsUsed", []) + document.get("extensionsRequired", [])
    print(f"FOUND {name}: {result}, extensions {used}")
    sizes.append(os.path.getsize(path[:-4] + "bin"))
print("FOUND same size:", sizes[0] == sizes[1])
PY
"$work/venv/bin/python" "$work/export.py" "$work" 2>/dev/null | sed -n 's/^FOUND //p' | tee "$work/found"
diff "$work/found" - <<'WANT' || { echo "the behaviour has changed"; exit 1; }
plain: {'FINISHED'}, extensions []
draco: {'FINISHED'}, extensions []
same size: True
WANT
echo "as described"
