// Adaptive transparency (Salvi, Montgomery and Lefohn 2011): twin of crates/render/src/method/adaptive.rs.
//
// The paper changes a pixel's steps as its fragments are drawn, which takes ordered access to memory from
// fragment shaders. There is none here: fragments go to a list a pixel first, and are taken from it in the
// order of their triangles, which is the order that such access keeps. The picture is the paper's; the list's
// memory comes on top.
#import shared/chunks
#import shared/composited
#import shared/counters
#import shared/order_by_triangle
#import shared/shade

// A step: what is seen through everything up to it.
struct Node {
    depth: f32,
    triangle: u32,
    transmittance: f32,
}

// Front to back; one more than may stay.
var<private> nodes: array<Node, P_NODES + 1u>;
var<private> node_count: u32;

// What is seen in front of a step.
fn before_node(at: u32) -> f32 {
    if at == 0u {
        return 1.0;
    }
    return nodes[at - 1u].transmittance;
}

// What is seen of a fragment.
fn seen_at(depth: f32, triangle: u32) -> f32 {
    var at = 0u;
    while at < node_count && is_in_front(nodes[at].depth, nodes[at].triangle, depth, triangle) {
        at += 1u;
    }
    return before_node(at);
}

fn insert_node(depth: f32, triangle: u32, transmittance: f32) {
    var at = node_count;
    while at > 0u && is_in_front(depth, triangle, nodes[at - 1u].depth, nodes[at - 1u].triangle) {
        nodes[at] = nodes[at - 1u];
        nodes[at].transmittance *= transmittance;
        at -= 1u;
    }
    nodes[at] = Node(depth, triangle, before_node(at) * transmittance);
    node_count += 1u;
}

// Joins the step that matters least with the one in front of it. There are at least two.
fn remove_least() {
    var least = 0u;
    var least_area = 0.0;
    for (var at = 0u; at + 1u < node_count; at += 1u) {
        let width = nodes[at + 1u].depth - nodes[at].depth;
        let area = width * (nodes[at].transmittance - nodes[at + 1u].transmittance);
        if at == 0u || area < least_area {
            least = at;
            least_area = area;
        }
    }
    nodes[least].transmittance = nodes[least + 1u].transmittance;
    for (var at = least + 2u; at < node_count; at += 1u) {
        nodes[at - 1u] = nodes[at];
    }
    node_count -= 1u;
    counted.merged += 1u;
}

// The first pass: visibility over depth.
fn build_visibility(pixel: vec2u, ray: CameraRay) {
    node_count = 0u;
    begin_chunks();
    while next_chunk(pixel, ray) {
        for (var at = 0u; at < chunk_count; at += 1u) {
            insert_node(chunk[at].depth, chunk[at].hit.triangle, 1.0 - chunk[at].alpha);
            if node_count > P_NODES {
                remove_least();
            }
        }
    }
}

fn composited(pixel: vec2u, ray: CameraRay) -> Composited {
    build_visibility(pixel, ray);
    var result = Composited(vec3f(0.0), before_node(node_count), node_count > 0u, false, Hit());
    begin_chunks();
    while next_chunk(pixel, ray) {
        for (var at = 0u; at < chunk_count; at += 1u) {
            let hit = chunk[at].hit;
            counted.hits += 1u;
            counted.shaded += 1u;
            result.rgb_premul += seen_at(chunk[at].depth, hit.triangle) * chunk[at].alpha * shade(ray, hit, pixel);
            if !result.has_furthest || is_behind(hit, result.furthest) {
                result.furthest = hit;
                result.has_furthest = true;
            }
        }
    }
    let rest = tail(pixel);
    result.rgb_premul += result.transmittance * rest.xyz;
    result.transmittance *= 1.0 - rest.w;
    result.transparent = result.transparent || rest.w > 0.0;
    return result;
}
