"""What to do about each warning."""

from __future__ import annotations

import re

_NOTHING = "nothing: the picture is the same"
_BAKE = "bake the texture into one that lies like that of the base colour, and repeats"
_SPLIT = "give parts that differ their own material, where the mean is not good enough"
_TOML = "in [material.NAME] of a TOML file"
_REMEDIES = (
    (r"no light", "add [[light]] to a TOML file, or emission to a material"),
    (r"no texture coordinates", "unwrap the meshes, and export texture coordinates"),
    (r"degenerate|have no area|without area|in no face", _NOTHING),
    (r"in 32 bits", "move the mesh to the origin in the program that made it, and export it again"),
    (r"coincide", "delete one copy of doubled faces, unless any will do"),
    (r"add up to more than 1|lowered to 1", f"lower the reflectance in the file, or {_TOML}"),
    (r"textures?\b.* grey|relief w.* not readable", "put the images where the file looks for them"),
    (r"MTL file", f"put the MTL file beside the OBJ, or give the reflectances {_TOML}"),
    (r"\b(normalTexture|map_[Bb]ump|[Bb]ump|norm|disp)\b", "model the relief, where it matters"),
    (r"(colours|opacity) of (vertices|faces)|attribute bytes", "bake the colours into a texture"),
    (r"animations", "export the pose to be rendered as a plain mesh"),
    (
        r"points and lines|lines are not simulated|fewer than three corners",
        "export what should be seen as polygons",
    ),
    (r"emission from the back", "model the light closed, or with a second face, turned back"),
    (r"absolute name", _NOTHING + ", if it is the right image"),
    (r"variation of|mean of (map_|its image)|map_(Ks|Ns)", _SPLIT),
    (r"KHR_materials_transmission", f"make it all glass: transmission 1, or ior {_TOML}"),
    (r"roughness of thin glass", f"model its two sides, or give it a partial alpha {_TOML}"),
    (r"specularColorFactor", f"give the colour as glossy {_TOML}"),
    (r"EXT_mesh_gpu_instancing", "realize its instances and export again: one copy is rendered"),
    (
        r"KHR_materials_(?!transmission)|EXT_(?!mesh_gpu)",
        f"describe the surface {_TOML}, as near as it gets",
    ),
    (r"\brange\b", "nothing: light falls off with the square of the distance"),
    (r"clamped in one|coordinates of a further texture", _BAKE),
    (r"mirrored view", "give the camera's node a scale without minus signs"),
    (
        r"\.ply: .*\btexture of",
        "give it as reflectance = { file = … } in [material.default] of a TOML file",
    ),
    (r"candela and lux", "export it anew, with Data → Lighting → Unitless"),
    (r"black backs", "nothing, where the camera and lights are in front of them"),
    (r"innerConeAngle", "lower it in the file: the edge of the spot is hard"),
    (r"newmtl is repeated", "give each material its own name"),
    (r"\b(Ks|Ns|Ni|Tf|illum|halo)\b", f"give mirror, glossy or ior {_TOML}"),
    (r"\bsheen\b", f"give sheen {_TOML}, without coat, ior and mirror"),
    (r"\bsheenRoughnessTexture\b", f"give sheen_roughness {_TOML}: one number stands for it"),
    (r"munsell", "give the measured chips with --munsell, or accept the recovered curve"),
)
"""A pattern in a warning, and what to do."""
_OTHER_FORMAT = r"^(?!.*\.(gltf|glb): ).*\b(property|element|texture)\b"
_EXPORT = "export it as glTF or OBJ with materials, if it matters"
_OTHERWISE = "compare a render with what it should show"


def find_remedy(message: str) -> str:
    """Return what to do about a warning, for each part of it that is known, in their order."""
    matches = [(re.search(pattern, message), remedy) for pattern, remedy in _REMEDIES]
    places = sorted((match.start(), remedy) for match, remedy in matches if match)
    found = [remedy for _, remedy in places]
    if not found and re.search(_OTHER_FORMAT, message):
        return _EXPORT
    return "; ".join(dict.fromkeys(found)) or _OTHERWISE
