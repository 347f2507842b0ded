// Shades what pass/find.wgsl has found, the background where that is nothing: one shader for all methods of
// one shaded fragment.
#import shared/resolve_pixel

@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_shade(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    pixel_at = id.xy;
    let ray = camera_ray(sample_of(pixel_at));
    let found = found_from_surface(surfaces[pixel_at.y * frame.size.x + pixel_at.x]);
    write_pixel(pixel_at, seen_by(ray, found, pixel_at), ray, found.found, found.hit, found.transparent);
    hand_in_counts();
}
