// What passes that add frames up read and write. They see pixels alone, so that group 0 is theirs.
#import shared/temporal_uniform
#import struct/PixelRecord

@group(GROUP_TEMPORAL) @binding(BIND_NEW_PIXELS) var<storage, read> pixels: array<PixelRecord>;
// What has been added up before this frame, linear and premultiplied.
@group(GROUP_TEMPORAL) @binding(BIND_HISTORY) var<storage, read> history: array<vec4f>;
@group(GROUP_TEMPORAL) @binding(BIND_NEXT_HISTORY) var<storage, read_write> next_history: array<vec4f>;
