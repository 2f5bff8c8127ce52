"""Build a scene in code, render it in 6 bands and save it."""

import trimesh

import photonmap as pm

wall = pm.Material("wall", 0.7)
clay = pm.Material("clay", (0.6, 0.25, 0.15))
leaf = pm.Material(
    "leaf", pm.Spectrum([400, 500, 550, 600, 680, 700], [0.04, 0.05, 0.2, 0.1, 0.05, 0.4])
)
lamp = pm.Material("lamp", 0.8, emission=(9.0, 8.0, 6.0))

room = trimesh.creation.box(extents=(4, 3, 4))
room.invert()
ball = trimesh.creation.icosphere(subdivisions=4, radius=0.6)
ball.apply_translation((-0.8, -0.9, -0.6))
ring = trimesh.creation.torus(0.55, 0.22, major_sections=96, minor_sections=48)
ring.apply_transform(trimesh.transformations.rotation_matrix(1.25, (1, 0, 0), (0, 0, 0)))
ring.apply_translation((0.75, -0.85, -0.4))
panel = pm.Mesh(
    [[-0.6, 1.49, -0.6], [0.6, 1.49, -0.6], [0.6, 1.49, 0.6], [-0.6, 1.49, 0.6]],
    [[0, 1, 2], [0, 2, 3]],
    lamp,
    "panel",
)

scene = pm.Scene(
    meshes=[
        pm.Mesh.from_trimesh(room, wall, "room"),
        pm.Mesh.from_trimesh(ball, clay, "ball", smooth=True),
        pm.Mesh.from_trimesh(ring, leaf, "ring", smooth=True),
        panel,
    ],
    camera=pm.Camera(origin=(0.2, 0.4, 1.95), target=(0.0, -0.75, -0.3), fov=60.0),
)
result = pm.render(scene, bands=6, size=(320, 240), passes=16)
result.save("built_in_code.exr")
print(result)
print("bands:", ", ".join(f"{nm:.0f} nm" for nm in result.bands.centroids))
print(f"error {result.record['error']:.3f} in {result.record['seconds']['render']:.1f} s")
