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
    let surface = surfaces[pixel_at.y * frame.size.x + pixel_at.x];
    let found = found_from_surface(surface);
    let colour = seen_by(ray, found, (surface.w & SURFACE_BEHIND_GLASS) != 0u, pixel_at);
    write_pixel(pixel_at, colour, ray, found.found, found.hit, found.transparent);
    hand_in_counts();
}
