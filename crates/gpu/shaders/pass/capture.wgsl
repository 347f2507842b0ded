// Puts every transparent fragment that nothing opaque hides into its pixel's list. Those that find the pool
// full are summed up by the blending units: the tail.
#import shared/counters
#import shared/opaque
#import shared/shade
#import shared/tail_targets
#import struct/ListNode

// First node of each pixel, counted from 1; after the last pixel, how many nodes were asked for.
@group(GROUP_OWN) @binding(BIND_LIST_HEADS) var<storage, read_write> list_heads: array<atomic<u32>>;
@group(GROUP_OWN) @binding(BIND_LIST_NODES) var<storage, read_write> list_nodes: array<ListNode>;

@fragment
fn fs_capture(vertex: TriangleVertex) -> Tail {
    let pixel = vec2u(vertex.position.xy);
    pixel_at = pixel;
    let hit = fragment_hit(pixel, vertex.triangle);
    if hit.t < 0.0 {
        discard;
    }
    let alpha = alpha_of(hit);
    if alpha <= 0.0 || alpha >= 1.0 || is_hidden(pixel, hit) {
        discard;
    }
    let node = atomicAdd(&list_heads[frame.size.x * frame.size.y], 1u);
    if node < arrayLength(&list_nodes) {
        let next = atomicExchange(&list_heads[pixel.y * frame.size.x + pixel.x], node + 1u);
        list_nodes[node] = ListNode(hit.triangle, next);
        discard;
    }
    counted.merged += 1u;
    counted.shaded += 1u;
    let rgb = shade(camera_ray(sample_of(pixel)), hit, pixel);
    hand_in_counts();
    return tail_of(rgb, alpha);
}
