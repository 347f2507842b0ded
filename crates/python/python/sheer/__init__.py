"""Order-independent transparency: render scenes full of transparent surfaces, compare methods, measure.

    import sheer

    scene = sheer.open("model.glb")
    picture = sheer.render(scene, "joint", size=(960, 540))
    picture.colour          # float32 (540, 960, 4), linear, premultiplied
    picture.save("picture.exr")

    sheer.compare(scene, ["std", "weighted"], size=(400, 225))
    sheer.metrics.ssim(reference, image)

Everything runs on the processor, without Python's lock.
"""

from . import metrics
from ._sheer import (
    Camera,
    Picture,
    Scene,
    Sequence,
    SheerError,
    SheerWarning,
    __version__,
    compare,
    methods,
    open,
    render,
    scenes,
    sequence,
)

__all__ = [
    "Camera",
    "Picture",
    "Scene",
    "Sequence",
    "SheerError",
    "SheerWarning",
    "__version__",
    "compare",
    "methods",
    "metrics",
    "open",
    "render",
    "scenes",
    "sequence",
]
