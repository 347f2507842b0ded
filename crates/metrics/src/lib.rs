//! Image in, number out: SSIM, PSNR and friends.
