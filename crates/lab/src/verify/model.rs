//! A second way to what dithering makes of constant layers: the definitions of the papers, simulated in
//! doubles by code that shares nothing with the renderer but the masks of blue noise, and drawn with random
//! numbers of its own.

use sheer_core::{blue_noise::blue_noise_64, hash::Pcg32, spatio_temporal};

/// Width and height of a picture: a multiple of the maps' sides, 3 and 5, so that no cell counts more than
/// another.
pub(super) const SIDE: usize = 30;
/// After these, 0.1 % of the first frame is left in the average.
pub(super) const FRAMES: u32 = 64;
/// Of the new frame in the exponential average (STD Eq. 2).
pub(super) const WEIGHT: f64 = 0.1;

/// Side of the static blue noise.
const NOISE_SIDE: usize = 64;
/// Maps that STD section 3.3 keeps.
const MAP_COUNT: usize = 288;

/// Equal layers in front of a blue background, red and green in turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stack {
    pub(super) count: u32,
    pub(super) alpha: f64,
}

impl Stack {
    /// The scene to be rendered.
    pub(super) fn scene(self) -> String {
        format!("layers:count={},alpha={},colours=red-green,background=1", self.count, self.alpha)
    }

    /// The layers of a scene hold a 32-bit alpha.
    fn held_alpha(self) -> f64 {
        f64::from(self.alpha as f32)
    }

    /// Exactly what is seen of red, green and blue from layer `first` on, of what reaches it.
    pub(super) fn shares_from(self, first: u32) -> [f64; 3] {
        let (mut shares, mut transmittance) = ([0.0; 3], 1.0);
        for layer in first..self.count {
            shares[layer as usize % 2] += transmittance * self.held_alpha();
            transmittance *= 1.0 - self.held_alpha();
        }
        shares[2] = transmittance;
        shares
    }

    /// Exactly what is seen.
    pub(super) fn colour(self) -> [f64; 3] {
        self.shares_from(0)
    }
}

/// A method of one shaded fragment, as its paper defines it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pattern {
    /// STD Listing 4: a map for each layer, one static blue noise for all.
    Std,
    /// The same with an offset into the noise for each layer.
    StdOwnNoise,
    /// The five strata of STD Listing 1, permuted for each layer (DTAA*).
    DtaaUnique,
    /// A place in a spatio-temporal mask for each layer (Wolfe et al. 2022).
    Stbn,
    /// One threshold for all layers, held against what they cover together; the noise moves by the golden
    /// ratio each nine frames.
    Joint,
}

impl Pattern {
    /// Frames after which a pixel sees the same again, at most as many as the average takes in.
    pub(super) fn period(self) -> u32 {
        match self {
            Self::Std | Self::StdOwnNoise => 9,
            Self::DtaaUnique => 5,
            Self::Stbn => spatio_temporal::FRAME_COUNT,
            Self::Joint => FRAMES,
        }
    }
}

/// What a layer draws once for a picture.
#[derive(Clone, Copy, Debug)]
struct Own {
    map: usize,
    permutation: [usize; 5],
    /// Column, row and frame.
    offset: [usize; 3],
}

/// The maps and masks that patterns are made of.
pub(super) struct Model {
    maps: Vec<[u8; 9]>,
    /// Row by row, in (0, 1).
    noise: Vec<f64>,
    /// Ranks of the spatio-temporal mask.
    ranks: &'static [u16],
}

impl Model {
    pub(super) fn new() -> Self {
        let ranks = blue_noise_64().ranks();
        let noise = ranks.iter().map(|&rank| (f64::from(rank) + 0.5) / ranks.len() as f64).collect();
        Self { maps: maps(), noise, ranks: spatio_temporal::spatio_temporal_ranks() }
    }

    /// All 288 maps.
    pub(super) fn maps(&self) -> &[[u8; 9]] {
        &self.maps
    }

    /// The blue noise of a pixel, in (0, 1).
    pub(super) fn noise(&self, x: usize, y: usize) -> f64 {
        self.noise[y % NOISE_SIDE * NOISE_SIDE + x % NOISE_SIDE]
    }

    /// The exponential average of all frames, red, green and blue, row by row. Each call draws anew.
    pub(super) fn picture(&self, pattern: Pattern, stack: Stack, random: &mut Pcg32) -> Vec<[f64; 3]> {
        let own: Vec<Own> = (0..stack.count).map(|_| self.draw(random)).collect();
        let shift = [0, 1].map(|_| random.below(3 * NOISE_SIDE as u32) as usize);
        let weights = weights_of_phases(pattern.period());
        let alpha = stack.held_alpha();
        let mut picture = Vec::with_capacity(SIDE * SIDE);
        for (x, y) in (0..SIDE * SIDE).map(|at| (at % SIDE, at / SIDE)) {
            let mut colour = [0.0; 3];
            for (frame, weight) in weights.iter().enumerate() {
                let seen = if pattern == Pattern::Joint {
                    let threshold = self.joint_threshold(x + shift[0], y + shift[1], frame);
                    let mut transmittance = 1.0;
                    own.iter().position(|_| {
                        transmittance *= 1.0 - alpha;
                        1.0 - transmittance > threshold
                    })
                } else {
                    own.iter().position(|own| alpha >= self.threshold(pattern, *own, x, y, frame))
                };
                colour[seen.map_or(2, |layer| layer % 2)] += weight;
            }
            picture.push(colour);
        }
        picture
    }

    fn draw(&self, random: &mut Pcg32) -> Own {
        let mut permutation = [0, 1, 2, 3, 4];
        for last in (1..5).rev() {
            permutation.swap(last, random.below(last as u32 + 1) as usize);
        }
        let sides = [NOISE_SIDE as u32, NOISE_SIDE as u32, spatio_temporal::FRAME_COUNT];
        let offset = sides.map(|side| random.below(side) as usize);
        Own { map: random.below(self.maps.len() as u32) as usize, permutation, offset }
    }

    fn threshold(&self, pattern: Pattern, own: Own, x: usize, y: usize, frame: usize) -> f64 {
        let [dx, dy, df] = own.offset;
        match pattern {
            Pattern::Std => (f64::from(listing_4(&self.maps[own.map], x, y, frame)) + self.noise(x, y)) / 9.0,
            Pattern::StdOwnNoise => {
                (f64::from(listing_4(&self.maps[own.map], x, y, frame)) + self.noise(x + dx, y + dy)) / 9.0
            }
            Pattern::DtaaUnique => (own.permutation[listing_1(x, y, frame)] as f64 + self.noise(x, y)) / 5.0,
            Pattern::Stbn => {
                let frames = spatio_temporal::FRAME_COUNT as usize;
                let plane = (frame + df) % frames * NOISE_SIDE * NOISE_SIDE;
                let place = (y + dy) % NOISE_SIDE * NOISE_SIDE + (x + dx) % NOISE_SIDE;
                (f64::from(self.ranks[plane + place]) + 0.5) / self.ranks.len() as f64
            }
            Pattern::Joint => unreachable!("its threshold belongs to a pixel, not to a layer"),
        }
    }

    /// A stratum of the first map, and inside it the noise, moved by the golden ratio as often as nine frames
    /// have gone by.
    fn joint_threshold(&self, x: usize, y: usize, frame: usize) -> f64 {
        let golden_ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        let moved = (self.noise(x, y) + (frame / 9) as f64 * golden_ratio).fract();
        (f64::from(listing_4(&self.maps[0], x, y, frame)) + moved) / 9.0
    }
}

/// `stratify` of STD Listing 4: the walk from left to right and back, a row further every three frames.
pub(super) fn listing_4(map: &[u8; 9], x: usize, y: usize, frame: usize) -> u8 {
    let row = frame / 3;
    let column = if row % 2 == 1 { 2 - frame % 3 } else { frame % 3 };
    map[(y + row) % 3 * 3 + (x + column) % 3]
}

/// `stratify` of STD Listing 1.
pub(super) fn listing_1(x: usize, y: usize, frame: usize) -> usize {
    (x + frame + 2 * (y + frame)) % 5
}

/// What each phase of a period weighs in the exponential average of all frames.
pub(super) fn weights_of_phases(period: u32) -> Vec<f64> {
    let mut weights = vec![0.0; period.min(FRAMES) as usize];
    for frame in 0..FRAMES {
        let new = if frame == 0 { 1.0 } else { WEIGHT };
        weights[(frame % period) as usize] += new * (1.0 - WEIGHT).powi((FRAMES - 1 - frame) as i32);
    }
    weights
}

/// The maps of STD section 3.3 by brute force: no neighbours on the torus differ by one; of these the 288 of
/// the highest score (Eq. 6), by falling score, then in the order of their numbers.
fn maps() -> Vec<[u8; 9]> {
    fn fill(map: &mut Vec<u8>, found: &mut Vec<[u8; 9]>) {
        if let Ok(whole) = <[u8; 9]>::try_from(map.as_slice()) {
            let mut differences = neighbours().map(|(a, b)| whole[a].abs_diff(whole[b]));
            if differences.all(|difference| difference != 1) {
                found.push(whole);
            }
            return;
        }
        for number in 0..9 {
            if !map.contains(&number) {
                map.push(number);
                fill(map, found);
                map.pop();
            }
        }
    }
    let mut found = Vec::new();
    fill(&mut Vec::new(), &mut found);
    let score =
        |map: &[u8; 9]| -> u32 { neighbours().map(|(a, b)| u32::from(map[a].abs_diff(map[b])).pow(2)).sum() };
    found.sort_by_key(|map| (std::cmp::Reverse(score(map)), *map));
    found.truncate(MAP_COUNT);
    found
}

/// Each cell with the one to its right and the one below, around the edges.
fn neighbours() -> impl Iterator<Item = (usize, usize)> {
    (0..9).flat_map(|at| {
        let (x, y) = (at % 3, at / 3);
        [(at, y * 3 + (x + 1) % 3), (at, (y + 1) % 3 * 3 + x)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RMS error over all channels, mean square over draws.
    fn rms(pattern: Pattern, count: u32, alpha: f64) -> f64 {
        let (model, stack, mut random) = (Model::new(), Stack { count, alpha }, Pcg32::new(77, 0));
        let exact = stack.colour();
        let (mut squares, mut terms) = (0.0, 0.0);
        for _ in 0..400 {
            for found in model.picture(pattern, stack, &mut random) {
                squares += (0..3).map(|at| (found[at] - exact[at]).powi(2)).sum::<f64>();
                terms += 3.0;
            }
        }
        (squares / terms).sqrt()
    }

    #[test]
    fn the_maps_are_those_of_the_renderer() {
        assert_eq!(maps(), sheer_core::threshold_map::std_maps());
    }

    #[test]
    fn the_simulation_gives_what_another_one_gave() {
        // A simulation in another language, of 1200 to 5000 pictures of nine pixels; 400 pictures scatter by
        // a fiftieth, and the tile's own noise is not all of the noise.
        for (pattern, count, alpha, known) in [
            (Pattern::Std, 2, 0.45, 0.096),
            (Pattern::Std, 8, 0.2, 0.136),
            (Pattern::Std, 20, 0.1, 0.228),
            (Pattern::Std, 40, 0.05, 0.467),
            (Pattern::StdOwnNoise, 2, 0.45, 0.096),
            (Pattern::StdOwnNoise, 8, 0.2, 0.119),
            (Pattern::StdOwnNoise, 20, 0.1, 0.119),
            (Pattern::StdOwnNoise, 40, 0.05, 0.141),
        ] {
            let found = rms(pattern, count, alpha);
            assert!((found / known - 1.0).abs() < 0.08, "{pattern:?}, {count}×{alpha}: {found}, not {known}");
        }
    }

    #[test]
    fn the_weights_of_all_phases_are_one() {
        for period in [5, 9, 16, 64] {
            assert!((weights_of_phases(period).iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}
