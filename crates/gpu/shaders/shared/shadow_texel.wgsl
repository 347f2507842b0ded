// A texel of a stochastic shadow map: for each channel the depth of the first blocker that each sample keeps;
// with alpha correction also the depths of the opaque surface and of the last transparent one, and for each
// channel the true total drop and the factor from the estimate to it.
#import shared/frame

// 3 where light takes on colour, else 1: red stands for all.
fn shadow_channels() -> u32 {
    return select(1u, 3u, frame.tinted != 0u);
}

// Numbers of a texel.
fn shadow_stride() -> u32 {
    let corrected = select(0u, 2u + 2u * shadow_channels(), SHADOW_IS_CORRECTED);
    return shadow_channels() * SHADOW_SAMPLES + corrected;
}
