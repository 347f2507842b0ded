//! Void and cluster: Ulichney, *The void-and-cluster method for dither array generation*, 1993, on a torus of
//! two dimensions, or of three where the third is time.
//!
//! Pixels are ranked so that, for every threshold, those below it are spread evenly without a grid. Where the
//! paper leaves a choice it is fixed here: the lower index among equals. Energies are whole numbers, so that
//! adding and taking away pixels is exact and every machine builds the same mask. The lowest and the highest
//! energy of each row are remembered, and after a change only those of the rows around it are looked up
//! again.

use crate::hash::Pcg32;

/// The energy of a pixel at its own position.
const ENERGY_ONE: f64 = (1_u32 << 24) as f64;

/// Flag of a set pixel beside its energy: all of a full mask must stay below it.
const SET: u32 = 1 << 31;

/// Size of a torus, pixels and frames; each a power of two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Torus {
    /// Columns and rows of a plane.
    pub side: u32,
    /// Frames; 1 for a mask without time.
    pub depth: u32,
}

impl Torus {
    fn count(self) -> u32 {
        self.side * self.side * self.depth
    }
}

/// Ranks all pixels, frame by frame, row by row. `crowding` gives, for a step in x, y and time of at most
/// `reach` each, how much two pixels so far apart crowd one another: 1 at the same position, 0 where they do
/// not matter. Over all steps it sums up to less than 128.
pub(crate) fn rank_all(
    torus: Torus,
    seed: u64,
    reach: i32,
    crowding: impl Fn(i32, i32, i32) -> f64,
) -> Vec<u16> {
    let count = torus.count();
    let mut pattern = Pattern::empty(torus, reach, crowding);

    // Initial pattern: a tenth of the pixels at random, then moved from clusters to voids until nothing
    // moves.
    let first_count = (count / 10).max(1);
    let mut random = Pcg32::new(seed, 0);
    let mut missing = first_count;
    while missing > 0 {
        let index = random.below(count) as usize;
        if !pattern.is_set(index) {
            pattern.toggle(index);
            missing -= 1;
        }
    }
    loop {
        let cluster = pattern.tightest_cluster();
        pattern.toggle(cluster);
        let void = pattern.largest_void();
        pattern.toggle(void);
        if void == cluster {
            break;
        }
    }

    // Phase 1: the ranks of the initial pattern, by taking away the tightest cluster.
    let mut ranks = vec![0_u16; count as usize];
    let initial: Vec<usize> = (0..count as usize).filter(|&index| pattern.is_set(index)).collect();
    for rank in (0..first_count).rev() {
        let cluster = pattern.tightest_cluster();
        pattern.toggle(cluster);
        ranks[cluster] = rank as u16;
    }
    initial.into_iter().for_each(|index| pattern.toggle(index));

    // Phases 2 and 3: fill the largest void. Ulichney's third phase takes the tightest cluster of the unset
    // pixels, which is the same pixel: on a torus the energies of set and unset pixels add up to a constant.
    for rank in first_count..count {
        let void = pattern.largest_void();
        pattern.toggle(void);
        ranks[void] = rank as u16;
    }
    ranks
}

/// Energies in one row of the mask around a changed pixel.
struct KernelRow {
    dy: i32,
    dt: i32,
    /// Step in x and energy.
    energies: Vec<(i32, u32)>,
}

/// A pattern of set pixels and how crowded each pixel is by them.
struct Pattern {
    side: i32,
    depth: i32,
    kernel: Vec<KernelRow>,
    /// Energy, with [`SET`] where the pixel is set: so the least is an unset pixel, the greatest a set one.
    keys: Vec<u32>,
    row_least: Vec<u32>,
    row_greatest: Vec<u32>,
}

impl Pattern {
    fn empty(torus: Torus, reach: i32, crowding: impl Fn(i32, i32, i32) -> f64) -> Self {
        let energies = |dy, dt| -> Vec<(i32, u32)> {
            let energy = |dx| (crowding(dx, dy, dt) * ENERGY_ONE).round() as u32;
            (-reach..=reach).map(|dx| (dx, energy(dx))).filter(|&(_, energy)| energy > 0).collect()
        };
        let kernel = (-reach..=reach)
            .flat_map(|dt| (-reach..=reach).map(move |dy| (dy, dt)))
            .map(|(dy, dt)| KernelRow { dy, dt, energies: energies(dy, dt) })
            .filter(|row| !row.energies.is_empty())
            .collect();
        let row_count = (torus.side * torus.depth) as usize;
        Self {
            side: torus.side as i32,
            depth: torus.depth as i32,
            kernel,
            keys: vec![0; torus.count() as usize],
            row_least: vec![0; row_count],
            row_greatest: vec![0; row_count],
        }
    }

    fn is_set(&self, index: usize) -> bool {
        self.keys[index] & SET != 0
    }

    fn toggle(&mut self, index: usize) {
        let adds = !self.is_set(index);
        self.keys[index] ^= SET;
        let (x, row) = (index as i32 % self.side, index as i32 / self.side);
        let (y, t) = (row % self.side, row / self.side);
        let wrap = self.side - 1;
        for KernelRow { dy, dt, energies } in &self.kernel {
            let row = (((t + dt) & (self.depth - 1)) * self.side + ((y + dy) & wrap)) as usize;
            let keys = &mut self.keys[row * self.side as usize..][..self.side as usize];
            for &(dx, energy) in energies {
                let key = &mut keys[((x + dx) & wrap) as usize];
                *key = if adds { *key + energy } else { *key - energy };
            }
            self.row_least[row] = keys.iter().copied().fold(u32::MAX, u32::min);
            self.row_greatest[row] = keys.iter().copied().fold(0, u32::max);
        }
    }

    /// The most crowded set pixel, the first among equals.
    fn tightest_cluster(&self) -> usize {
        let greatest = self.row_greatest.iter().copied().fold(0, u32::max);
        self.first(&self.row_greatest, greatest)
    }

    /// The least crowded unset pixel, the first among equals.
    fn largest_void(&self) -> usize {
        let least = self.row_least.iter().copied().fold(u32::MAX, u32::min);
        self.first(&self.row_least, least)
    }

    fn first(&self, of_rows: &[u32], key: u32) -> usize {
        let position = |keys: &[u32]| {
            keys.iter().position(|&other| other == key).expect("the key is one that a row holds")
        };
        let first = position(of_rows) * self.side as usize;
        first + position(&self.keys[first..][..self.side as usize])
    }
}
