#!/usr/bin/env bash
# Blender's glTF exporter loses the weight of a sheen and the index of refraction of a coat.
#
# Version: bpy 5.2.3 (Blender as a Python module; needs Python 3.13), its own exporter of glTF 2.0.
# Behaviour: a Principled BSDF with "Sheen Weight" 0.5 and a white tint is written with sheenColorFactor [1, 1, 1], as with
#   a weight of 1: only the tint is written. KHR_materials_sheen has one colour, so the product of both would be right.
#   "Coat IOR" is not written at all, in no extension: readers take the coat's usual index of 1.5. The weight of the coat,
#   which stands beside it, is kept. The export ends without a warning.
# Why it matters: a cloth that is half as strong in Blender comes back from glTF twice as strong, and a renderer that is
#   compared with Cycles through glTF seems to be wrong.
# Seen (November 2026):
#   sheen 0.25 -> [1.0, 1.0, 1.0]
#   sheen 0.5 -> [1.0, 1.0, 1.0]
#   sheen 1.0 -> [1.0, 1.0, 1.0]
#   coat {'clearcoatFactor': 0.5} index 2.0 in ['KHR_materials_clearcoat']
# The script exits with 1 if that changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3.13}" -m venv "$work/venv"
"$work/venv/bin/pip" install -q bpy==5.2.3
cat >"$work/export.py" <<'PY'
import json, sys
import bpy

def material(**inputs):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_plane_add()
    made = bpy.data.materials.new("cloth")
    made.use_nodes = True
    bpy.context.object.data.materials.append(made)
    node = made.node_tree.nodes["Principled BSDF"]
    for name, value in inputs.items():
        node.inputs[name.replace("_", " ")].default_value = value
    path = sys.argv[1] + "/cloth.gltf"
    bpy.ops.export_scene.gltf(filepath=path, export_format="GLTF_SEPARATE")
    with open(path) as file:
        return json.load(file)["materials"][0]["extensions"]

for weight in 0.25, 0.5, 1.0:
    sheen = material(Sheen_Weight=weight, Sheen_Tint=(1, 1, 1, 1))["KHR_materials_sheen"]
    print("FOUND sheen", weight, "->", sheen["sheenColorFactor"])
coat = material(Coat_Weight=0.5, Coat_IOR=2)
print("FOUND coat", {"clearcoatFactor": coat["KHR_materials_clearcoat"]["clearcoatFactor"]}, "index 2.0 in", sorted(coat))
PY
"$work/venv/bin/python" "$work/export.py" "$work" 2>/dev/null | sed -n 's/^FOUND //p' | tee "$work/found"
diff "$work/found" - <<'WANT' || { echo "the behaviour has changed"; exit 1; }
sheen 0.25 -> [1.0, 1.0, 1.0]
sheen 0.5 -> [1.0, 1.0, 1.0]
sheen 1.0 -> [1.0, 1.0, 1.0]
coat {'clearcoatFactor': 0.5} index 2.0 in ['KHR_materials_clearcoat']
WANT
echo "as described"
