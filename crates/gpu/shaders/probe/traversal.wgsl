// All hits of rays, and the nearest with the lowest index, through what `traverse` stands for. Hits of
// DROPPED do not count.
#import shared/intersect
#expand traverse VISITOR=all
#expand traverse VISITOR=closest

struct ProbeRay {
    origin: vec3f,
    t_min: f32,
    direction: vec3f,
    t_max: f32,
}

struct Answer {
    count: u32,
    sum: u32,
    t: f32,
    u: f32,
    v: f32,
    triangle: u32,
    front: u32,
    // Whether `barycentrics` gives other numbers.
    differs: u32,
}

@group(GROUP_PASS) @binding(BIND_PROBE_IN) var<storage, read> rays: array<ProbeRay>;
@group(GROUP_PASS) @binding(BIND_PROBE_OUT) var<storage, read_write> answers: array<Answer>;

var<private> count: u32;
var<private> sum: u32;
var<private> best: Hit;

fn visit_all(hit: Hit) -> u32 {
    if hit.triangle != DROPPED {
        count++;
        sum += hit.triangle;
    }
    return GO_ON;
}

fn visit_closest(hit: Hit) -> u32 {
    if best.triangle == MISS || hit.t < best.t || hit.triangle < best.triangle {
        best = hit;
        return END_HERE;
    }
    return GO_ON;
}

@compute @workgroup_size(PROBE_GROUP)
fn cs_probe(@builtin(global_invocation_id) id: vec3u) {
    let ray = rays[id.x];
    best = no_hit();
    traverse_all(ray.origin, ray.direction, ray.t_min, ray.t_max);
    traverse_closest(ray.origin, ray.direction, ray.t_min, ray.t_max);
    var differs = 0u;
    if best.triangle != MISS {
        let again = barycentrics(watertight_ray(ray.origin, ray.direction), best.triangle);
        differs = u32(again.t != best.t || again.u != best.u || again.v != best.v || again.front != best.front);
    }
    answers[id.x] = Answer(count, sum, best.t, best.u, best.v, best.triangle, u32(best.front), differs);
}
