//! What one file may take of the machine.

/// What geometry and animation may take in memory, whatever the size of the file.
pub(super) const BASE_BYTES: u64 = 512 << 20;
/// What they may take on top of that for each byte read: the compression formats reach ratios of about 30.
pub(super) const BYTES_PER_INPUT_BYTE: u64 = 64;
/// What all images of a file may take in memory when decoded.
pub(super) const IMAGE_BYTES: u64 = 6 << 30;

/// Triangles that frames may hold, at some 200 bytes each with the hierarchy: those of instances that share
/// them once.
pub(super) const MAX_STORED_TRIANGLES: u64 = 1 << 26;
/// Triangles that may be drawn, each instance counted: the acceleration structure knows no more by number.
pub(super) const MAX_DRAWN_TRIANGLES: u64 = 1 << 30;
