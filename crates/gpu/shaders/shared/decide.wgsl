// What the backend does with a threshold: twins of sheer_render::contract::keeps and sheer_core::coverage.

// The decision of STD Listings 3 and 4, with both ends exact: next to nothing is never kept, opaque always.
fn keeps(alpha: f32, threshold: f32) -> bool {
    return alpha >= MIN_ALPHA && (alpha >= 1.0 || alpha >= threshold);
}

// The coverage, 0 to 1, that is held against thresholds for an opacity, 0 to 1 (STD section 3.2.1); both ends
// stay what they are.
fn coverage(alpha: f32) -> f32 {
    if alpha <= 0.0 || alpha >= 1.0 {
        return alpha;
    }
    let c = P_CORRECTION_COEFFICIENTS;
    return clamp(((c.w * alpha + c.z) * alpha + c.y) * alpha + c.x, 0.0, 1.0);
}
