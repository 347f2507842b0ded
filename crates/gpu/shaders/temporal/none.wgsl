// Each frame by itself: twin of crates/render/src/temporal/none.rs.
#import shared/temporal

fn resolved(pixel: vec2u, current: PixelRecord) -> vec4f {
    return current.colour;
}
