// Calls visit_VISITOR for hits within [t_min, t_max], in no promised order; each triangle once.
//
// The driver finds candidates; the numbers of a hit are ours (`barycentrics`), so that all paths see the
// same. The driver's interval excludes its ends and its t rounds otherwise, so it gets a wider one. A hit at
// exactly the ray's origin is lost.
#import shared/accel_query
#import shared/intersect
#import shared/visit

fn traverse_VISITOR(origin: vec3f, direction: vec3f, t_min: f32, t_max: f32) {
    if !is_traceable(origin, direction) || !(max(t_min, 0.0) <= t_max) {
        return;
    }
    let ray = watertight_ray(origin, direction);
    let nearest = max(t_min, 0.0);
    var farthest = t_max;
    // At function scope: naga makes invalid SPIR-V of a query that is declared in a loop.
    var query: ray_query;
    rayQueryInitialize(
        &query,
        scene_accel,
        RayDesc(0u, 0xffu, nearest * (1.0 - QUERY_SLACK), t_max * (1.0 + QUERY_SLACK), origin, direction),
    );
    while rayQueryProceed(&query) {
        let candidate = rayQueryGetCandidateIntersection(&query);
        let hit = barycentrics(ray, order[candidate.instance_custom_data + candidate.primitive_index]);
        if !(nearest <= hit.t) {
            continue;
        }
        if hit.t > farthest {
            // Nothing from here on matters to the driver either. Confirming the hit that ended the ray would
            // lose others at its distance.
            if hit.t > farthest * (1.0 + QUERY_SLACK) {
                rayQueryConfirmIntersection(&query);
            }
            continue;
        }
        let answer = visit_VISITOR(hit);
        if answer == STOP {
            rayQueryTerminate(&query);
            return;
        }
        if answer == END_HERE {
            farthest = hit.t;
        }
    }
}
