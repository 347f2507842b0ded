// The list of a pixel and the opaque surface behind it in the place of a ray's traversal.
#import shared/listed
#import shared/visit

fn traverse_VISITOR(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32) {
    let surface = opaque_surface(pixel_at);
    if surface.found && visit_VISITOR(surface.hit) == STOP {
        return;
    }
    let ray = watertight_ray(origin, direction);
    var node = list_heads[pixel_at.y * frame.size.x + pixel_at.x];
    while node != LIST_END {
        let listed = list_nodes[node - 1u];
        if visit_VISITOR(barycentrics(ray, listed.triangle)) == STOP {
            return;
        }
        node = listed.next;
    }
}
