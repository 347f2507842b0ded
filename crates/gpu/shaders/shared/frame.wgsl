// What a frame is rendered with, the same in every pass.
#import struct/FrameUniform

@group(GROUP_SCENE) @binding(BIND_FRAME) var<uniform> frame: FrameUniform;
