"""Translates a scene from `ptfast scenes show --json` to a scene of Mitsuba 3."""

import math
import os
import tempfile

import mitsuba as mi
import numpy


def only(tagged):
    """Returns the kind and the values of an object whose only key names its kind."""
    return next(iter(tagged.items()))


def color(value, textures, folder="", raw=False):
    """Returns a colour or a texture. A texture must show a mesh with texture coordinates of its own."""
    if isinstance(value, (int, float)):
        return value
    if isinstance(value, str):
        kind, texture = only(textures[value])
        if kind == "image":
            wrap = texture.get("wrap_u", "repeat")
            if texture.get("wrap_v", "repeat") != wrap or "rotation" in texture or "offset" in texture:
                raise SystemExit(f"the texture {value} cannot be translated to Mitsuba")
            scale = [*texture.get("scale", [1, 1]), 1]
            return {"type": "bitmap", "filename": os.path.join(folder, texture["file"]), "wrap_mode": wrap,
                    "filter_type": texture.get("filter", "bilinear"), "to_uv": mi.ScalarTransform4f().scale(scale),
                    # Otherwise bytes are rounded to 16-bit floats.
                    "format": "variant",
                    "raw": raw or texture.get("encoding") == "linear"}
        if kind == "checker":
            value = [0.5 * (a + b) for a, b in zip(texture["odd"], texture["even"])]
        else:
            raise SystemExit(f"{kind} textures cannot be translated to Mitsuba, only checkers and images")
    return {"type": "rgb", "value": value}


def environment(values, folder):
    """Returns an environment map. Mitsuba's shows +z in the middle, that of ptfast -z. The first and the last row of
    Mitsuba's maps are at the poles, while ptfast interpolates between the middles of rows and clamps at the poles. A map
    of twice as many rows and one more makes both the same."""
    if values.get("mapping", "lat_long") != "lat_long":
        raise SystemExit("only latitude-longitude maps can be translated to Mitsuba")
    to_world = mi.ScalarTransform4f()
    for axis in (2, 1, 0):
        angle = values.get("rotation", [0, 0, 0])[axis]
        to_world = to_world.rotate([float(axis == i) for i in range(3)], angle)
    to_world = to_world.rotate([0, 1, 0], 180)
    bitmap = mi.Bitmap(os.path.join(folder, values["file"]))
    rows = numpy.array(bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False))
    stretched = numpy.empty((2 * len(rows) + 1, *rows.shape[1:]), rows.dtype)
    stretched[1::2] = rows
    stretched[2:-1:2] = (rows[:-1] + rows[1:]) / 2
    stretched[0], stretched[-1] = rows[0], rows[-1]
    return {"type": "envmap", "bitmap": mi.Bitmap(stretched), "scale": values.get("scale", 1.0), "to_world": to_world}


def free_light(description):
    kind, values = only(description)
    if kind == "point":
        return {"type": "point", "position": values["position"],
                "intensity": {"type": "rgb", "value": values["intensity"]}}
    if kind == "distant" and values.get("angle", 0) == 0:
        return {"type": "directional", "direction": values["direction"],
                "irradiance": {"type": "rgb", "value": values["irradiance"]}}
    raise SystemExit(f"the light {description} cannot be translated to Mitsuba")


def material(description, textures, exact, folder=""):
    """Returns a material for Mitsuba, or None for a light. If `exact`, rejects materials that Mitsuba does not have."""
    kind, values = only(description)
    if exact and (values.get("opacity") or values.get("normal") and kind != "lambertian"
                  or any(isinstance(values.get(name), dict) for name in ("alpha", "coat", "fuzz", "metalness", "roughness"))
                  or values.get("emission", [0, 0, 0]) != [0, 0, 0]):
        raise SystemExit(f"this script does not translate all of {description}")
    fuzzy = kind == "metal" and values.get("fuzz", 0.0) > 0
    by_schlick = kind == "dielectric" and values.get("fresnel", "schlick") == "schlick"
    if exact and (kind == "diffuse" or fuzzy or by_schlick):
        raise SystemExit(f"Mitsuba has no material like {description}")
    if kind in ("lambertian", "diffuse"):
        plain = {"type": "diffuse", "reflectance": color(values["albedo"], textures, folder)}
        if values.get("normal"):
            plain = {"type": "normalmap", "bsdf": plain, "use_shadowing_function": False,
                     "normalmap": color(values["normal"], textures, folder, raw=True)}
    elif kind == "conductor":
        plain = {"type": "roughconductor", "distribution": "ggx", "alpha": values["alpha"],
                 "eta": {"type": "rgb", "value": values["eta"]}, "k": {"type": "rgb", "value": values["k"]}}
        if values["alpha"] == 0:
            plain = {**plain, "type": "conductor"}
            del plain["alpha"], plain["distribution"]
    elif kind == "coated_diffuse":
        plain = {"type": "plastic", "int_ior": values["ior"], "ext_ior": 1.0, "nonlinear": True,
                 "diffuse_reflectance": color(values["reflectance"], textures, folder)}
        if values["roughness"] > 0:
            plain.update(type="roughplastic", distribution="ggx", alpha=values["roughness"] ** 2)
    elif kind == "rough_dielectric":
        return {"type": "roughdielectric", "distribution": "ggx", "alpha": values["alpha"],
                "int_ior": values["ior"], "ext_ior": 1.0}
    elif kind == "metal":
        plain = {"type": "roughconductor", "material": "none", "alpha": 0.5 * values.get("fuzz", 0.0),
                 "specular_reflectance": color(values["albedo"], textures)}
        if plain["alpha"] < 1e-3:
            plain.pop("alpha")
            plain["type"] = "conductor"
    elif kind == "principled":
        # Without metal, the base and the glass of Mitsuba's model differ from ours.
        if exact and (values["metalness"] < 1 or values["coat"] > 0 or values["roughness"] > 0.15):
            raise SystemExit(f"Mitsuba has no material like {description}")
        plain = {"type": "principled", "base_color": color(values["base_color"], textures, folder),
                 "metallic": values["metalness"], "roughness": values["roughness"]}
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


def shape(description, folder=""):
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
        flat = values.get("smooth") == "off"
        if not flat and values.get("soft_terminator", True):
            raise SystemExit(f"to be translated to Mitsuba, the mesh {values['file']} needs smooth: off, or "
                             "normals and soft_terminator: false")
        _, extension = os.path.splitext(values["file"])
        file = os.path.join(folder, values["file"])
        return {"type": extension[1:], "filename": file, "face_normals": flat,
                "to_world": placement(values)}, values["material"]
    raise SystemExit(f"the primitive {kind} cannot be translated to Mitsuba")


def placement(values):
    """Returns the transform of a mesh: a scale, rotations about x, y and z, a translation, and a matrix."""
    to_world = mi.ScalarTransform4f()
    if "matrix" in values:
        if numpy.linalg.det(numpy.array(values["matrix"])[:, :3]) < 0:
            raise SystemExit(f"the mesh {values['file']} is mirrored, so its front cannot be translated to Mitsuba")
        to_world = mi.ScalarTransform4f(values["matrix"] + [[0, 0, 0, 1]])
    to_world = to_world.translate(values.get("translation", [0, 0, 0]))
    for axis in (2, 1, 0):
        to_world = to_world.rotate([float(axis == i) for i in range(3)], values.get("rotation", [0, 0, 0])[axis])
    return to_world.scale(values.get("scale", 1))


def triangles(values):
    normals = values.get("normals", [])
    if normals and values.get("soft_terminator", True):
        raise SystemExit("Mitsuba does not soften the terminator, so smooth triangles need soft_terminator: false")
    with tempfile.NamedTemporaryFile("w", suffix=".obj", delete=False) as file:
        for vertex in values["vertices"]:
            print("v", *vertex, file=file)
        for u, v in values.get("uvs", []):
            print("vt", u, v, file=file)
        for normal in normals:
            print("vn", *normal, file=file)
        for face in values["indices"]:
            corner = "{0}" + ("/{0}" if "uvs" in values else "/" if normals else "") + ("/{0}" if normals else "")
            print("f", *(corner.format(i + 1) for i in face), file=file)
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


def translate(scene, width, height, exact, sampler="independent", folder="", rr_depth=5):
    """Returns the scene for Mitsuba. Paths of files are relative to `folder`. `rr_depth` is that of Mitsuba's
    integrator, where 5 is the default. It means Russian roulette from segment `rr_depth` + 1 on."""
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
             "integrator": {"type": "path", "max_depth": scene["render"]["depth"], "rr_depth": rr_depth}}
    kind, background = only(scene["background"])
    if kind == "image":
        world["background"] = environment(background, folder)
    elif kind != "constant":
        raise SystemExit(f"{kind} backgrounds cannot be translated to Mitsuba, only constant ones and images")
    elif max(background["radiance"]) > 0:
        world["background"] = {"type": "constant", "radiance": {"type": "rgb", "value": background["radiance"]}}
    for number, description in enumerate(scene.get("lights", [])):
        world[f"light{number}"] = free_light(description)
    made = {name: material(description, textures, exact, folder)
            for name, description in scene["materials"].items()}
    for name, parts in scene.get("meshes", {}).items():
        group = {"type": "shapegroup"}
        for number, description in enumerate(parts):
            translated, material_name = shape(description, folder)
            group[f"part{number}"] = {**translated, "bsdf": made[material_name]}
        world[f"group_{name}"] = group
    for number, description in enumerate(scene["primitives"]):
        kind, values = only(description)
        if kind == "instance":
            to_world = mi.ScalarTransform4f(values["matrix"] + [[0, 0, 0, 1]])
            group = {"type": "ref", "id": f"group_{values['mesh']}"}
            world[f"shape{number}"] = {"type": "instance", "to_world": to_world, "group": group}
            continue
        translated, name = shape(description, folder)
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
