// What a visitor of hits answers.

// Hits behind this one count as well.
const GO_ON: u32 = 0u;
// Nothing behind this hit matters; others at the same distance do.
const END_HERE: u32 = 1u;
// No further hit matters.
const STOP: u32 = 2u;
