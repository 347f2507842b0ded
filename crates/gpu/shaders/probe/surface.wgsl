// Answers what a frame says of points of its triangles: one invocation a query.
#import shared/scene
#import shared/surface

struct Query {
    triangle: u32,
    u: f32,
    v: f32,
    counter_clockwise: u32,
    direction: vec3f,
    width: f32,
}

@group(GROUP_PASS) @binding(BIND_PROBE_IN) var<storage, read> queries: array<Query>;
@group(GROUP_PASS) @binding(BIND_PROBE_OUT) var<storage, read_write> answers: array<f32>;

var<private> next_answer: u32;

fn answer(value: f32) {
    answers[next_answer] = value;
    next_answer++;
}

fn answer3(value: vec3f) {
    answer(value.x);
    answer(value.y);
    answer(value.z);
}

@compute @workgroup_size(PROBE_GROUP)
fn cs_probe(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    next_answer = id.x * ANSWER_LENGTH;
    let query = queries[id.x];
    let counter_clockwise = query.counter_clockwise != 0u;
    let surface = surface_at(
        Hit(1.0, query.u, query.v, query.triangle, counter_clockwise), Beam(query.direction, query.width),
    );
    let alpha = opacity(query.triangle, query.u, query.v, query.width);
    answer(alpha);
    answer(opacity_for_camera(query.triangle, query.u, query.v, counter_clockwise, query.width));
    answer(f32(surface.front));
    answer(surface.metallic);
    answer(surface.roughness);
    answer(surface.occlusion);
    answer3(surface.base_colour);
    answer3(surface.normal);
    answer3(surface.geometric_normal);
    answer3(surface.position);
    answer3(surface.previous_position);
    answer3(surface.emissive);
    answer3(light_through(query.triangle, query.u, query.v, counter_clockwise, alpha, query.width));
    let corners = corners_in_object(query.triangle);
    answer3(corners[0]);
    answer3(corners[1]);
    answer3(corners[2]);
}
