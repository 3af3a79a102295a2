"""A picture as a flat mesh: glTF in memory, the PNG inside, drawn without shading."""

import base64
import io
import json

import numpy as np
from PIL import Image
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh

_FLOAT, _USHORT = 5126, 5123  # glTF component types


def png_bytes(picture: Image.Image | bytes) -> bytes:
    """A Pillow image as PNG; bytes are taken to be PNG already."""
    if isinstance(picture, bytes):
        return picture
    stream = io.BytesIO()
    picture.save(stream, "PNG", optimize=True)
    return stream.getvalue()


def image_mesh(picture: Image.Image | bytes, width: float, height: float) -> InMemoryMesh:
    """A textured rectangle, centred at the origin of its frame, in the x-y plane, upright when y is up, seen from +z.

    Args:
        picture: Pillow image, or the bytes of a PNG; transparent parts stay transparent.
        width: extent along x [m].
        height: extent along y [m].
    """
    w, h = width / 2, height / 2
    # glTF is y-up and readers turn it to z-up: Drake's (x, y, z) is glTF's (x, z, -y).
    corners = np.array([[-w, 0, h], [w, 0, h], [w, 0, -h], [-w, 0, -h]], dtype=np.float32)
    normals = np.array([[0, 1, 0]] * 4, dtype=np.float32)
    texture = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], dtype=np.float32)
    triangles = np.array([0, 1, 2, 0, 2, 3], dtype=np.uint16)
    parts = [corners.tobytes(), normals.tobytes(), texture.tobytes(), triangles.tobytes()]
    offsets = np.cumsum([0, *map(len, parts)]).tolist()
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]}
        ],
        "materials": [
            {
                "alphaMode": "BLEND" if _has_alpha(picture) else "OPAQUE",
                "doubleSided": True,
                "extensions": {"KHR_materials_unlit": {}},
                "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0, "roughnessFactor": 1},
            }
        ],
        "textures": [{"source": 0}],
        "images": [{"uri": "data:image/png;base64," + base64.b64encode(png_bytes(picture)).decode()}],
        "buffers": [
            {
                "byteLength": offsets[-1],
                "uri": "data:application/octet-stream;base64," + base64.b64encode(b"".join(parts)).decode(),
            }
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(part)}
            for start, part in zip(offsets, parts, strict=False)
        ],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": _FLOAT,
                "count": 4,
                "type": "VEC3",
                "min": corners.min(axis=0).tolist(),
                "max": corners.max(axis=0).tolist(),
            },
            {"bufferView": 1, "componentType": _FLOAT, "count": 4, "type": "VEC3"},
            {"bufferView": 2, "componentType": _FLOAT, "count": 4, "type": "VEC2"},
            {"bufferView": 3, "componentType": _USHORT, "count": 6, "type": "SCALAR"},
        ],
    }
    return InMemoryMesh(mesh_file=MemoryFile(contents=json.dumps(document), extension=".gltf", filename_hint="image"))


def _has_alpha(picture: Image.Image | bytes) -> bool:
    image = Image.open(io.BytesIO(picture)) if isinstance(picture, bytes) else picture
    return image.has_transparency_data
