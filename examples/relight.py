"""Light is additive: render each light once, then mix them in any colour without rendering.

Here each light has a render of its own, which may be made and refined apart. One render with
`per_light=True` holds all lights apart too: see "Light groups" in docs/guide.md.
"""

import numpy as np

import photonmap as pm

box = pm.scenes.cornell_box()
walls = [mesh for mesh in box.meshes if mesh.name != "light"]


def lit_by(light, seed):
    """Render the box with a single light."""
    scene = pm.Scene(walls, [light], box.camera)
    return pm.render(scene, bands=6, size=(192, 192), passes=16, seed=seed)


window = lit_by(pm.PointLight((-0.6, 0.6, 0.4), 1.0, "window"), seed=1)
candle = lit_by(pm.PointLight((0.6, -0.2, 0.6), 1.0, "candle"), seed=2)

# A cold window and a warm candle, as factors per band.
centroids = window.bands.centroids
cold = 1.5 * (centroids / 550.0) ** -1.5
warm = 0.5 * (centroids / 550.0) ** 3.0
relit = window.radiance * cold + candle.radiance * warm
shading = window.shading * cold + candle.shading * warm
error = np.hypot(window.standard_error("radiance") * cold, candle.standard_error("radiance") * warm)

mixed = pm.Result({"radiance": relit, "shading": shading}, {"radiance": error}, window.bands, {})
mixed.save("relight.exr")
print(f"relit: mean radiance {relit.mean():.4f}, typical error {np.sqrt((error**2).mean()):.5f}")
