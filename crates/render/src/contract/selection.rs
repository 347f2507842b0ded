//! Methods that select one fragment of a pixel by a single threshold.

use super::tables::Tables;

/// Family of methods that hold one threshold a pixel against the coverage accumulated front to back, `1 - Π
/// (1 - alpha)`. The fragment with which the coverage first exceeds it is the one shaded, the background if
/// it never does. With a threshold uniform in [0, 1) each fragment comes with its share of the pixel, and
/// layers cannot mask one another. The price: the backend needs the hits in order.
pub trait Selection: Sync {
    /// Threshold in [0, 1) of the pixel at column and row `pixel`, in a frame of a run with a seed.
    fn threshold(&self, pixel: [u32; 2], frame: u32, seed: u32, tables: &Tables) -> f32;
}
