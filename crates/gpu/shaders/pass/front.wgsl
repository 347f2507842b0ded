// What a method makes of the transparent fragments of a pixel, for pass/composite.wgsl: two passes, since
// software drivers compile each place that shades anew, for seconds, and this one differs from method to
// method.
#import method
#import shared/composited
#import shared/counters
#import shared/drawn

@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_front(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    pixel_at = id.xy;
    let front = composited(pixel_at, camera_ray(sample_of(pixel_at)));
    var record: PixelRecord;
    record.colour = vec4f(front.rgb_premul, 1.0 - front.transmittance);
    record.transparent = select(0u, 1u, front.transparent);
    record.primitive = select(NONE, front.furthest.triangle, front.has_furthest);
    pixels[pixel_at.y * frame.size.x + pixel_at.x] = record;
    hand_in_counts();
}
