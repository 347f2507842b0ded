// One shaded fragment a pixel: which one it is, by the method. pass/shade.wgsl does the rest. Twin of
// `Tracer::stochastic` without a hybrid.
#import find
#import shared/camera
#import shared/counters
#import shared/found

@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_find(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    pixel_at = id.xy;
    let found = find(pixel_at, camera_ray(sample_of(pixel_at)), false, Hit());
    surfaces[pixel_at.y * frame.size.x + pixel_at.x] = surface_from_found(found);
    hand_in_counts();
}
