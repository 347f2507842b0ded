import os
from collections.abc import Iterator
from collections.abc import Sequence as Several
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

_Point: TypeAlias = tuple[float, float, float]
_Vector: TypeAlias = Several[float] | NDArray[Any]
_Source: TypeAlias = str | os.PathLike[str] | bytes | bytearray
_Clip: TypeAlias = ArrayLike | Several[ArrayLike]

class SheerError(Exception): ...
class SheerWarning(UserWarning): ...

@final
class Camera:
    def __new__(
        cls,
        eye: _Vector | None = None,
        target: _Vector | None = None,
        *,
        up: _Vector | None = None,
        fov: float | None = None,
        ortho: float | None = None,
    ) -> Camera: ...
    @property
    def eye(self) -> _Point | None: ...
    @property
    def target(self) -> _Point | None: ...
    @property
    def up(self) -> _Point | None: ...
    @property
    def fov(self) -> float | None: ...
    @property
    def ortho(self) -> float | None: ...

@final
class Scene:
    @staticmethod
    def from_arrays(
        positions: ArrayLike,
        indices: ArrayLike | None = None,
        rgba: ArrayLike | None = None,
        *,
        normals: ArrayLike | None = None,
        name: str = "arrays",
    ) -> Scene: ...
    @property
    def name(self) -> str: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def cameras(self) -> list[str]: ...
    @property
    def bounds(self) -> tuple[_Point, _Point]: ...
    @property
    def triangle_count(self) -> int: ...
    def content_hash(self) -> str: ...
    def pose(self, camera: str | Camera | None = None, time: float = 0.0) -> Camera: ...
    def with_alpha(self, alpha: float) -> Scene: ...
    def with_environment(self, environment: str | os.PathLike[str], strength: float = 1.0) -> Scene: ...

@final
class Picture:
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def colour(self) -> NDArray[np.float32]: ...
    @property
    def alpha(self) -> NDArray[np.float32]: ...
    @property
    def depth(self) -> NDArray[np.float32]: ...
    @property
    def motion(self) -> NDArray[np.float32]: ...
    @property
    def instance(self) -> NDArray[np.uint32]: ...
    @property
    def primitive(self) -> NDArray[np.uint32]: ...
    @property
    def transparent(self) -> NDArray[np.bool_]: ...
    @property
    def layers(self) -> dict[str, NDArray[Any]] | None: ...
    @property
    def info(self) -> dict[str, str]: ...
    def srgb(self) -> NDArray[np.uint8]: ...
    def displayed(self) -> NDArray[np.float32]: ...
    def save(self, path: str | os.PathLike[str]) -> None: ...
    def _repr_png_(self) -> bytes: ...

@final
class Sequence:
    def __iter__(self) -> Iterator[Picture]: ...
    def __len__(self) -> int: ...
    def __next__(self) -> Picture: ...

def open(
    source: _Source,
    *,
    name: str | None = None,
    strict: bool = False,
    allowed_folders: Several[str | os.PathLike[str]] | None = None,
    clip: str | None = None,
    scene: str | None = None,
    variant: str | None = None,
    memory_limit: int | None = None,
) -> Scene: ...
def scenes() -> list[str]: ...
def methods() -> list[str]: ...
def render(
    scene: Scene | _Source,
    method: str = "joint",
    *,
    aa: str = "layered",
    size: tuple[int, int] | None = None,
    frames: int = 32,
    samples: int | None = None,
    shutter: float = 0.0,
    raw: bool = False,
    first_frame: int = 0,
    time: float = 0.0,
    fps: float = 30.0,
    camera: str | Camera | None = None,
    background: str = "env",
    shadow: str | None = None,
    tone: str | None = None,
    exposure: float = 0.0,
    seed: int = 0,
    threads: int | None = None,
) -> Picture: ...
def sequence(
    scene: Scene | _Source,
    method: str = "joint",
    *,
    aa: str = "layered",
    size: tuple[int, int] | None = None,
    frames: int = 32,
    samples: int | None = None,
    shutter: float = 0.0,
    raw: bool = False,
    warm_up: int | None = None,
    first_frame: int = 0,
    time: float = 0.0,
    fps: float = 30.0,
    camera: str | Camera | None = None,
    background: str = "env",
    shadow: str | None = None,
    tone: str | None = None,
    exposure: float = 0.0,
    seed: int = 0,
    threads: int | None = None,
) -> Sequence: ...
def compare(
    scene: Scene | _Source,
    methods: str | Several[str],
    *,
    aa: str | Several[str] | None = None,
    reference: str | Several[str] | None = None,
    size: tuple[int, int] | None = None,
    frames: int = 32,
    vdp: bool = False,
    first_frame: int = 0,
    time: float = 0.0,
    fps: float = 30.0,
    camera: str | Camera | None = None,
    background: str = "env",
    shadow: str | None = None,
    tone: str | None = None,
    exposure: float = 0.0,
    seed: int = 0,
    threads: int | None = None,
) -> list[dict[str, Any]]: ...
def ssim(reference: ArrayLike, image: ArrayLike) -> float: ...
def ssim_map(reference: ArrayLike, image: ArrayLike) -> NDArray[np.float32]: ...
def psnr(reference: ArrayLike, image: ArrayLike) -> float: ...
def flip(reference: ArrayLike, image: ArrayLike) -> float: ...
def flip_map(
    reference: ArrayLike, image: ArrayLike, pixels_per_degree: float | None = None
) -> NDArray[np.float32]: ...
def rms(reference: ArrayLike, image: ArrayLike) -> float: ...
def bias(reference: ArrayLike, image: ArrayLike) -> float: ...
def flicker(references: _Clip, images: _Clip) -> float: ...
def tpsnr(references: _Clip, images: _Clip) -> float | None: ...
def vdp(references: _Clip, images: _Clip, fps: float = 30.0) -> float: ...
def error_map(
    reference: ArrayLike, image: ArrayLike, full_scale: float | None = None
) -> NDArray[np.uint8]: ...
