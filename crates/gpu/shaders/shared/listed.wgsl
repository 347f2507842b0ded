// The lists that pass/capture.wgsl has made, complete.
#import shared/list
#import shared/opaque
#import shared/tail_targets

@group(2) @binding(1) var<storage, read> list_heads: array<u32>;
@group(2) @binding(2) var<storage, read> list_nodes: array<ListNode>;
