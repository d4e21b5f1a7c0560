#!/usr/bin/env bash
# Blender's glTF exporter loses the strength of a sun if the scene is rendered with Cycles.
#
# Version: bpy 5.2.3 (Blender as a Python module; needs Python 3.13), its own exporter of glTF 2.0.
# Behaviour: with the render engine EEVEE, a sun of 5 W/m² is written as a directional light of 5 · 683 = 3415 lux. With the
#   render engine Cycles, every sun is written with 683 lux, whatever its strength: the exporter reads the strength of
#   the emission node in the lamp's own nodes, which new lamps have and which is 1, and leaves the lamp's energy out.
#   Cycles itself multiplies both. Point lamps keep their energy under both engines.
# Why it matters: a scene that was lit with Cycles, where suns of 3 to 5 W/m² are usual, comes back several times too
#   dark from glTF, beside other lamps that are right.
# Seen (November 2026):
#   BLENDER_EEVEE: sun of 1 -> 683, sun of 5 -> 3415, point lamp of 5 -> 272
#   CYCLES: sun of 1 -> 683, sun of 5 -> 683, point lamp of 5 -> 272
# The script exits with 1 if that changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3.13}" -m venv "$work/venv"
"$work/venv/bin/pip" install -q bpy==5.2.3
cat >"$work/export.py" <<'PY'
import json, sys
import bpy

def exported(engine, kind, energy):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.engine = engine
    data = bpy.data.lights.new("lamp", kind)
    data.energy = energy
    bpy.context.collection.objects.link(bpy.data.objects.new("lamp", data))
    path = sys.argv[1] + "/lamp.gltf"
    bpy.ops.export_scene.gltf(filepath=path, export_format="GLTF_SEPARATE", export_lights=True)
    with open(path) as file:
        return round(json.load(file)["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"])

for engine in "BLENDER_EEVEE", "CYCLES":
    one, five, point = (exported(engine, *lamp) for lamp in (("SUN", 1), ("SUN", 5), ("POINT", 5)))
    print(f"FOUND {engine}: sun of 1 -> {one}, sun of 5 -> {five}, point lamp of 5 -> {point}")
PY
"$work/venv/bin/python" "$work/export.py" "$work" 2>/dev/null | sed -n 's/^FOUND //p' | tee "$work/found"
diff "$work/found" - <<'WANT' || { echo "the behaviour has changed"; exit 1; }
BLENDER_EEVEE: sun of 1 -> 683, sun of 5 -> 3415, point lamp of 5 -> 272
CYCLES: sun of 1 -> 683, sun of 5 -> 683, point lamp of 5 -> 272
WANT
echo "as described"
