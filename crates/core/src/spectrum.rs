//! Spectra of masks, for tests.

use std::f64::consts::TAU;

/// Cycles per pixel below which the eye sees structure at a glance; the mask's energy peaks near 0.5.
pub(crate) const LOW_FREQUENCY: f64 = 0.15;

/// Mean power of the frequencies up to `limit` cycles per pixel, relative to that of all frequencies but
/// 0.
pub(crate) fn low_frequency_share(values: &[f32], side: usize, limit: f64) -> f64 {
    let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
    let wave: Vec<(f64, f64)> =
        (0..side).map(|k| (TAU * k as f64 / side as f64).sin_cos()).map(|(s, c)| (c, -s)).collect();
    // One discrete Fourier transform along x, one along y; 64 pixels need no faster one.
    let transform = |input: &dyn Fn(usize) -> (f64, f64), frequency: usize| {
        (0..side).fold((0.0, 0.0), |(re, im), i| {
            let ((a, b), (c, d)) = (input(i), wave[frequency * i % side]);
            (re + a * c - b * d, im + a * d + b * c)
        })
    };
    let rows: Vec<(f64, f64)> = (0..side * side)
        .map(|i| transform(&|x| (f64::from(values[i / side * side + x]) - mean, 0.0), i % side))
        .collect();
    let (mut low, mut all) = ((0.0, 0), (0.0, 0));
    for (fx, fy) in (0..side * side).map(|i| (i % side, i / side)).skip(1) {
        let (re, im) = transform(&|y| rows[y * side + fx], fy);
        let power = re * re + im * im;
        let cycles = |f: usize| f.min(side - f) as f64 / side as f64;
        if cycles(fx).hypot(cycles(fy)) <= limit {
            low = (low.0 + power, low.1 + 1);
        }
        all = (all.0 + power, all.1 + 1);
    }
    (low.0 / f64::from(low.1)) / (all.0 / f64::from(all.1))
}
