// The lists that pass/capture.wgsl has made, complete.
#import shared/opaque
#import shared/tail_targets
#import struct/ListNode

@group(GROUP_OWN) @binding(BIND_LIST_HEADS) var<storage, read> list_heads: array<u32>;
@group(GROUP_OWN) @binding(BIND_LIST_NODES) var<storage, read> list_nodes: array<ListNode>;
