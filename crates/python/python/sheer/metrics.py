"""How far pictures are from a reference, on arrays: the figures of the command line.

SSIM, PSNR and FLIP take what a display shows (sRGB), rms and bias linear light; flicker, tpsnr and vdp take
clips for a display. Pictures of different sizes, and clips of different lengths, raise ValueError.
"""

from ._sheer import (
    bias,
    error_map,
    flicker,
    flip,
    flip_map,
    psnr,
    rms,
    ssim,
    ssim_map,
    tpsnr,
    vdp,
)

__all__ = [
    "bias",
    "error_map",
    "flicker",
    "flip",
    "flip_map",
    "psnr",
    "rms",
    "ssim",
    "ssim_map",
    "tpsnr",
    "vdp",
]
