// All of a pixel is one layer: what `Tracer::pixel` says of methods that do not tell layers apart.
#import shared/frame
#import shared/pass
#import struct/LayersRecord

@group(GROUP_PASS) @binding(BIND_LAYERS) var<storage, read_write> layer_records: array<LayersRecord>;

@compute @workgroup_size(GROUP_SIDE, GROUP_SIDE)
fn cs_one_layer(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let index = id.y * frame.size.x + id.x;
    var record: LayersRecord;
    record.front_depth = NO_DEPTH;
    record.back_motion = pixels[index].motion;
    record.back_depth = pixels[index].depth;
    layer_records[index] = record;
}
