// Lists of fragments, one a pixel, in one pool for all (Yang et al. 2010, Real-Time Concurrent Linked List Construction on the GPU).

struct ListNode {
    triangle: u32,
    // Index of the next node, counted from 1; LIST_END after the last.
    next: u32,
}

const LIST_END: u32 = 0u;
