"""Translates a scene from `ptfast scenes show --json` to a scene of Mitsuba 3."""

import math
import os
import tempfile

import mitsuba as mi


def only(tagged):
    """Returns the kind and the values of an object whose only key names its kind."""
    return next(iter(tagged.items()))


def color(value, textures):
    if isinstance(value, str):
        kind, texture = only(textures[value])
        if kind == "checker":
            value = [0.5 * (a + b) for a, b in zip(texture["odd"], texture["even"])]
        else:
            raise SystemExit(f"{kind} textures cannot be translated to Mitsuba, only checkers")
    return {"type": "rgb", "value": value}


def material(description, textures, exact):
    """Returns a material for Mitsuba, or None for a light. If `exact`, rejects materials that Mitsuba does not have."""
    kind, values = only(description)
    fuzzy = kind == "metal" and values.get("fuzz", 0.0) > 0
    by_schlick = kind == "dielectric" and values.get("fresnel", "schlick") == "schlick"
    if exact and (kind == "diffuse" or fuzzy or by_schlick):
        raise SystemExit(f"Mitsuba has no material like {description}")
    if kind in ("lambertian", "diffuse"):
        plain = {"type": "diffuse", "reflectance": color(values["albedo"], textures)}
    elif kind == "conductor":
        plain = {"type": "roughconductor", "distribution": "ggx", "alpha": values["alpha"],
                 "eta": {"type": "rgb", "value": values["eta"]}, "k": {"type": "rgb", "value": values["k"]}}
        if values["alpha"] == 0:
            plain = {**plain, "type": "conductor"}
            del plain["alpha"], plain["distribution"]
    elif kind == "rough_dielectric":
        return {"type": "roughdielectric", "distribution": "ggx", "alpha": values["alpha"],
                "int_ior": values["ior"], "ext_ior": 1.0}
    elif kind == "metal":
        plain = {"type": "roughconductor", "material": "none", "alpha": 0.5 * values.get("fuzz", 0.0),
                 "specular_reflectance": color(values["albedo"], textures)}
        if plain["alpha"] < 1e-3:
            plain.pop("alpha")
            plain["type"] = "conductor"
    elif kind == "dielectric":
        return {"type": "dielectric", "int_ior": values["ior"], "ext_ior": 1.0}
    else:
        return None
    return {"type": "twosided", "inner": plain}


def rectangle(q, u, v):
    normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    length = math.sqrt(sum(n * n for n in normal))
    rows = [[u[i] / 2, v[i] / 2, normal[i] / length, q[i] + (u[i] + v[i]) / 2] for i in range(3)]
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f(rows + [[0, 0, 0, 1]])}


def shape(description):
    kind, values = only(description)
    if kind == "sphere":
        if values.get("center1", values["center"]) != values["center"]:
            raise SystemExit("moving spheres cannot be translated to Mitsuba")
        return {"type": "sphere", "center": values["center"], "radius": values["radius"]}, values["material"]
    if kind == "quad":
        return rectangle(values["q"], values["u"], values["v"]), values["material"]
    if kind == "box":
        low, high = values["min"], values["max"]
        turn = values.get("rotation", [0, 0, 0])
        if turn[0] or turn[2]:
            raise SystemExit("only boxes turned about y can be translated to Mitsuba, not about x or z")
        half, middle = [[(b + s * a) / 2 for a, b in zip(low, high)] for s in (-1, 1)]
        to_world = mi.ScalarTransform4f().translate(middle).rotate([0, 1, 0], turn[1]).scale(half)
        return {"type": "cube", "to_world": to_world}, values["material"]
    if kind == "triangles":
        return triangles(values), values["material"]
    if kind == "mesh":
        if values.get("smooth") != "off":
            raise SystemExit(f"to be translated to Mitsuba, the mesh {values['file']} needs smooth: off")
        _, extension = os.path.splitext(values["file"])
        return {"type": extension[1:], "filename": values["file"], "face_normals": True}, values["material"]
    raise SystemExit(f"the primitive {kind} cannot be translated to Mitsuba")


def triangles(values):
    normals = values.get("normals", [])
    if normals and values.get("soft_terminator", True):
        raise SystemExit("Mitsuba does not soften the terminator, so smooth triangles need soft_terminator: false")
    with tempfile.NamedTemporaryFile("w", suffix=".obj", delete=False) as file:
        for vertex in values["vertices"]:
            print("v", *vertex, file=file)
        for normal in normals:
            print("vn", *normal, file=file)
        for face in values["indices"]:
            print("f", *(f"{i + 1}//{i + 1}" if normals else i + 1 for i in face), file=file)
    return {"type": "obj", "filename": file.name, "face_normals": not normals}


def medium(description):
    """Returns a shape with an invisible surface, filled with the medium."""
    kind, values = only(description)
    inside, _ = shape({kind: {**values, "material": None}})
    albedo = {"type": "rgb", "value": values["albedo"]}
    inside["interior"] = {"type": "homogeneous", "sigma_t": values["density"], "albedo": albedo,
                          "phase": {"type": "isotropic"}}
    inside["bsdf"] = {"type": "null"}
    return inside


def translate(scene, width, height, exact, sampler="independent"):
    camera, textures = scene["camera"], scene.get("textures", {})
    sensor = {
        "type": "perspective", "fov": camera["vfov"], "fov_axis": "y", "near_clip": 1e-3, "far_clip": 1e5,
        "to_world": mi.ScalarTransform4f().look_at(origin=camera["look_from"], target=camera["look_at"],
                                                   up=camera["up"]),
        "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}},
        "sampler": {"type": sampler},
    }
    if camera["defocus_angle"] > 0:
        radius = camera["focus_distance"] * math.tan(math.radians(camera["defocus_angle"] / 2))
        sensor.update(type="thinlens", aperture_radius=radius, focus_distance=camera["focus_distance"])
    world = {"type": "scene", "sensor": sensor,
             "integrator": {"type": "path", "max_depth": scene["render"]["depth"] + 1, "rr_depth": 5}}
    kind, background = only(scene["background"])
    if kind != "constant":
        raise SystemExit(f"{kind} backgrounds cannot be translated to Mitsuba, only constant ones")
    if max(background["radiance"]) > 0:
        world["background"] = {"type": "constant", "radiance": {"type": "rgb", "value": background["radiance"]}}
    made = {name: material(description, textures, exact) for name, description in scene["materials"].items()}
    for name, parts in scene.get("meshes", {}).items():
        group = {"type": "shapegroup"}
        for number, description in enumerate(parts):
            translated, material_name = shape(description)
            group[f"part{number}"] = {**translated, "bsdf": made[material_name]}
        world[f"group_{name}"] = group
    for number, description in enumerate(scene["primitives"]):
        kind, values = only(description)
        if kind == "instance":
            to_world = mi.ScalarTransform4f(values["matrix"] + [[0, 0, 0, 1]])
            group = {"type": "ref", "id": f"group_{values['mesh']}"}
            world[f"shape{number}"] = {"type": "instance", "to_world": to_world, "group": group}
            continue
        translated, name = shape(description)
        if made[name] is None:
            radiance, sides = (only(scene["materials"][name])[1].get(key) for key in ("radiance", "sides"))
            if exact and sides != "front" and only(description)[0] != "sphere":
                raise SystemExit(f"Mitsuba has no light that shines on both sides: {description}")
            translated["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": radiance}}
        else:
            translated["bsdf"] = made[name]
        world[f"shape{number}"] = translated
    for number, description in enumerate(scene.get("media", [])):
        world["integrator"]["type"] = "volpath"
        world[f"medium{number}"] = medium(description)
    return mi.load_dict(world)
