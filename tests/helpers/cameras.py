"""Cameras of every kind that maps points in space to film points."""

import photonmap as pm

CALIBRATED = (640, 480)
BROWN = (-0.31, 0.12, 0.0013, -0.0021, 0.015)
KANNALA = (0.05, -0.012, 0.0023, -0.0004)
CAMERAS = {
    "pinhole": {"fov": 50.0},
    "orthographic": {"height": 2.0},
    "shifted": {"projection": pm.Intrinsics(500.0, CALIBRATED, 460.0, 300.0, 250.0)},
    "Brown-Conrady": {"projection": pm.Intrinsics(520.0, CALIBRATED, 510.0, 330.0, 228.0, BROWN)},
    "fisheye": {"projection": pm.Fisheye(200.0)},
    "all around": {"projection": pm.Fisheye(360.0)},
    "OpenCV fisheye": {
        "projection": pm.FisheyeIntrinsics(210.0, CALIBRATED, 200.0, 310.0, 245.0, KANNALA)
    },
    "panorama": {"projection": pm.Panorama()},
}


def camera_of(name, **values):
    """A camera of a kind, askew."""
    return pm.Camera(
        (0.3, -0.2, 1.5), (-0.1, 0.1, -1.0), (0.1, 1.0, 0.2), **CAMERAS[name], **values
    )
