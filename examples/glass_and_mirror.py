"""Render a mirror ball and a glass ball, with caustics and specular light in separate buffers."""

import numpy as np
import OpenImageIO

import photonmap as pm

result = pm.render(pm.scenes.cornell_balls(), bands="rgb", size=(256, 256), passes=32)

names = ("radiance", "direct", "indirect", "caustics", "residual")
strip = np.concatenate([result.rgb(name) * result.exposure for name in names], axis=1)
image = OpenImageIO.ImageBuf(np.clip(strip, 0, 1).astype(np.float32))
image = OpenImageIO.ImageBufAlgo.colorconvert(image, "linear", "sRGB")
image.write("glass_and_mirror.png", "uint8")

for name, effect in result.record["effects"].items():
    print(f"{name:13} {'on' if effect['on'] else 'off':4} {effect['why']}")
