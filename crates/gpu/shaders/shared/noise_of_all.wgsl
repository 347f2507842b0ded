// The static blue noise that all objects share: twin of `Noise::of_all` in sheer_render's
// method/static_noise.rs.
#import shared/tables

// The noise of a pixel, in (0, 1).
fn noise_of_all(pixel: vec2u) -> f32 {
    if P_NOISE == P_NOISE_OFF {
        return MIDDLE_OF_STRATUM;
    }
    return blue_noise_at(pixel);
}
