"""Split an image into reflectance, shading, direct and indirect light, side by side."""

import numpy as np
import OpenImageIO

import photonmap as pm

result = pm.render(pm.scenes.cornell_box(), bands=6, size=(256, 256), passes=16)

names = ("radiance", "reflectance", "shading", "direct", "indirect")
exposure = result.exposure
strip = np.concatenate(
    [result.rgb(name) * (1.0 if name == "reflectance" else exposure) for name in names], axis=1
)
image = OpenImageIO.ImageBuf(np.clip(strip, 0, 1).astype(np.float32))
image = OpenImageIO.ImageBufAlgo.colorconvert(image, "linear", "sRGB")
image.write("split_buffers.png", "uint8")

diffuse = result.direct + result.indirect
print("reflectance × shading − (direct + indirect), maximum:",
      np.abs(result.reflectance * result.shading - diffuse).max())  # fmt: skip
for name in names:
    value, error = getattr(result, name), result.standard_error(name)
    print(f"{name:12} mean {value.mean():.4f} ± {np.sqrt((error**2).mean()):.4f} per pixel")
