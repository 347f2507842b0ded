// What the visibility buffer holds of a pixel.
#import shared/counters
#import shared/found
#import shared/triangles

@group(GROUP_OWN) @binding(BIND_VISIBLE_SURFACES) var visible_surfaces: texture_2d<u32>;
// The words of `Tested`.
@group(GROUP_OWN) @binding(BIND_TESTED) var<storage, read> tested: array<u32>;

fn find(pixel: vec2u, ray: CameraRay, has_after: bool, after: Hit) -> Found {
    let index = TESTED_WORDS * (pixel.y * frame.size.x + pixel.x);
    counted.hits += tested[index + TESTED_COUNT];
    let surface = textureLoad(visible_surfaces, pixel, 0);
    if surface.x == NONE {
        return Found(false, after, tested[index + TESTED_NEAREST] != 0u, false, vec3f(0.0));
    }
    let hit = fragment_hit(pixel, surface.x);
    let shown = Hit(hit.t, bitcast<f32>(surface.y), bitcast<f32>(surface.z), surface.x, surface.w != 0u);
    return Found(true, shown, ~tested[index + TESTED_NEAREST] <= bitcast<u32>(hit.t), false, vec3f(0.0));
}
