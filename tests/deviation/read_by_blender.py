"""What Blender finds in a PLY or a GLB, as JSON: blender --background --python read_by_blender.py -- FILE OUT"""
import json
import sys

import bpy
import numpy

numpy.bool = bool  # Debian 12 has a numpy that no longer has the name, and an importer of glTF that uses it

path, out = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
if path.endswith(".glb"):
    bpy.ops.import_scene.gltf(filepath=path, merge_vertices=False)
else:
    bpy.ops.import_mesh.ply(filepath=path)


def own(p):
    """The point in the file's axes: y is up in a glTF, z in Blender."""
    return [p[0], p[2], -p[1]] if path.endswith(".glb") else list(p)


found = next(o for o in bpy.data.objects if o.type == "MESH" and len(o.data.polygons) > 0)
mesh = found.data
layer = mesh.color_attributes[0]
colours = [None] * len(mesh.vertices)
for loop in mesh.loops:
    colour = layer.data[loop.index if layer.domain == "CORNER" else loop.vertex_index]
    colours[loop.vertex_index] = list(colour.color if path.endswith(".glb") else colour.color_srgb)[:3]
facts = {
    "positions": [own(v.co) for v in mesh.vertices],
    "place": own(found.matrix_world.translation),
    "triangles": [list(p.vertices) for p in mesh.polygons],
    "colours": colours,
    "extras": {key: found[key] for key in ("limit", "units", "lower", "upper") if key in found},
    "nodes": sorted(o.name for o in bpy.data.objects),
}
for attribute in mesh.attributes:
    if attribute.name.upper() == "_DISTANCE":
        facts["quality"] = [value.value for value in attribute.data]
with open(out, "w", encoding="utf-8") as file:
    json.dump(facts, file)
