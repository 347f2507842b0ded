// Puts what is opaque, or the background, behind the light that pass/front.wgsl has left in each pixel with,
// in place of a primitive, its furthest fragment's triangle: twin of `Tracer::behind`.
#import shared/opaque
#import shared/resolve_pixel

@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_composite(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    pixel_at = id.xy;
    let ray = camera_ray(sample_of(pixel_at));
    let front = pixels[pixel_at.y * frame.size.x + pixel_at.x];
    let surface = opaque_surface(pixel_at);
    let shows_background = 1.0 - front.colour.w > MIN_VISIBILITY;
    var colour = front.colour;
    if shows_background {
        colour = over(colour, seen(ray, surface.found, surface.hit, pixel_at));
    }
    // Where nothing is seen of the background the furthest fragment stands for the pixel. Methods that keep
    // sums alone do not know which that is: theirs is the surface behind all the same.
    var last = surface;
    if !shows_background && front.primitive != NONE {
        last = OpaqueSurface(true, fragment_hit(pixel_at, front.primitive));
    }
    write_pixel(pixel_at, colour, ray, last.found, last.hit, front.transparent != 0u);
    hand_in_counts();
}
