// The list of a pixel in an order that the method gives by `comes_before`, in bounded memory: each scan of
// the list takes the next few.
#import shared/drawn
#import shared/listed

// Fragments a scan takes: 32 bytes each of registers or local memory. Of n there are n / 16 scans, and one.
const CHUNK_SIZE: u32 = 16u;

var<private> chunk: array<Fragment, CHUNK_SIZE>;
var<private> chunk_count: u32;
// The last one of the chunk before.
var<private> chunk_after: Fragment;
var<private> chunk_has_after: bool;

// Starts over with the first.
fn begin_chunks() {
    chunk_count = 0u;
    chunk_has_after = false;
}

fn insert_into_chunk(fragment: Fragment) {
    if chunk_count == CHUNK_SIZE {
        if !comes_before(fragment, chunk[CHUNK_SIZE - 1u]) {
            return;
        }
        chunk_count -= 1u;
    }
    var index = chunk_count;
    while index > 0u && comes_before(fragment, chunk[index - 1u]) {
        chunk[index] = chunk[index - 1u];
        index -= 1u;
    }
    chunk[index] = fragment;
    chunk_count += 1u;
}

// Takes the next fragments; false if there are none left.
fn next_chunk(pixel: vec2u, ray: CameraRay) -> bool {
    if chunk_count > 0u {
        chunk_after = chunk[chunk_count - 1u];
        chunk_has_after = true;
        chunk_count = 0u;
    }
    let to_triangles = watertight_ray(ray.origin, ray.direction);
    var node = list_heads[pixel.y * frame.size.x + pixel.x];
    while node != LIST_END {
        let listed = list_nodes[node - 1u];
        let fragment = fragment_of(ray, barycentrics(to_triangles, listed.triangle));
        if !chunk_has_after || comes_before(chunk_after, fragment) {
            insert_into_chunk(fragment);
        }
        node = listed.next;
    }
    return chunk_count > 0u;
}
