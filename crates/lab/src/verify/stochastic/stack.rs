//! Constant layers over a background.

/// A constant layer over the whole pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer {
    /// Which surface it is.
    pub(super) id: u32,
    pub(super) alpha: f64,
    pub(super) rgb: [f64; 3],
}

impl Layer {
    pub(super) fn new(id: u32, alpha: f64, rgb: [f64; 3]) -> Self {
        Self { id, alpha, rgb }
    }
}

/// Layers front to back over a background.
#[derive(Clone, Debug)]
pub(super) struct Stack {
    pub(super) layers: Vec<Layer>,
    pub(super) background: [f64; 3],
}

impl Stack {
    /// ST section 3.1, Example 1: red over green over blue.
    pub(super) fn example_1() -> Self {
        let layers = vec![Layer::new(0, 0.45, [1.0, 0.0, 0.0]), Layer::new(1, 0.45, [0.0, 1.0, 0.0])];
        Self { layers, background: [0.0, 0.0, 1.0] }
    }

    /// Example 2: four thin white layers over grey.
    pub(super) fn example_2() -> Self {
        let layers = (0..4).map(|id| Layer::new(id, 0.25, [1.0; 3])).collect();
        Self { layers, background: [0.25; 3] }
    }

    /// One layer over black.
    pub(super) fn single(alpha: f64) -> Self {
        Self { layers: vec![Layer::new(0, alpha, [1.0; 3])], background: [0.0; 3] }
    }

    /// What is to be seen (ST Eq. 1).
    pub(super) fn colour(&self) -> [f64; 3] {
        self.layers.iter().rev().fold(self.background, |behind, Layer { alpha, rgb, .. }| {
            [0, 1, 2].map(|channel| alpha * rgb[channel] + (1.0 - alpha) * behind[channel])
        })
    }

    pub(super) fn transmittance(&self) -> f64 {
        self.layers.iter().map(|layer| 1.0 - layer.alpha).product()
    }
}
