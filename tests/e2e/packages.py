"""Archives that clients send: a .zip, and a 3MF of one mesh."""

import io
import zipfile

RELATIONSHIPS = """<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r"
Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/3D/m.model"/></Relationships>"""
MODEL = """<?xml version="1.0"?>
<model xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" unit="%s"><resources><object id="1"><mesh>
<vertices>%s</vertices><triangles>%s</triangles></mesh></object></resources><build><item objectid="1"/></build></model>"""


def zipped(files):
    """`files`: contents by name, or by ZipInfo. Entries have no time: the same bytes always."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name if isinstance(name, zipfile.ZipInfo) else zipfile.ZipInfo(name), content, archive.compression)
    return out.getvalue()


def package_3mf(unit, corners, triangles):
    """`corners`: of numbers or their texts; `triangles`: of indices."""
    vertices = "".join('<vertex x="%s" y="%s" z="%s"/>' % tuple(corner) for corner in corners)
    faces = "".join('<triangle v1="%d" v2="%d" v3="%d"/>' % tuple(triangle) for triangle in triangles)
    return zipped({"_rels/.rels": RELATIONSHIPS, "3D/m.model": MODEL % (unit, vertices, faces)})
