//! Hashes and a random stream: the integer ones give the same bits on every machine and in a shader of the
//! same name.

use glam::{Vec2, Vec3, Vec4};

/// Multiplier of the 32-bit linear congruential step (Jarzynski and Olano 2020, section 4.2).
pub const LCG_MULTIPLIER: u32 = 1_664_525;
/// Increment of the same step.
pub const LCG_INCREMENT: u32 = 1_013_904_223;

/// Multiplier of the step of [`pcg`].
pub const PCG_MULTIPLIER: u32 = 747_796_405;
/// Increment of the step of [`pcg`].
pub const PCG_INCREMENT: u32 = 2_891_336_453;
/// Multiplier of the output function of [`pcg`].
pub const PCG_OUTPUT_MULTIPLIER: u32 = 277_803_737;

/// One step of [`unit_from_bits`], 2⁻²⁴.
pub const UNIT_STEP: f32 = 1.0 / (1 << 24) as f32;

/// The largest 32-bit float below 1.
pub const BELOW_ONE: f32 = 1.0_f32.next_down();

/// Hash of one number, a bijection: `pcg` of Jarzynski and Olano, *Hash Functions for GPU Rendering*, JCGT 9
/// (3), 2020.
#[must_use]
pub const fn pcg(v: u32) -> u32 {
    let state = v.wrapping_mul(PCG_MULTIPLIER).wrapping_add(PCG_INCREMENT);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(PCG_OUTPUT_MULTIPLIER);
    (word >> 22) ^ word
}

/// Hash of two numbers to two, a bijection: `pcg2d` of Jarzynski and Olano 2020.
#[must_use]
pub const fn pcg2d([mut x, mut y]: [u32; 2]) -> [u32; 2] {
    x = lcg(x);
    y = lcg(y);
    x = x.wrapping_add(y.wrapping_mul(LCG_MULTIPLIER));
    y = y.wrapping_add(x.wrapping_mul(LCG_MULTIPLIER));
    x ^= x >> 16;
    y ^= y >> 16;
    x = x.wrapping_add(y.wrapping_mul(LCG_MULTIPLIER));
    y = y.wrapping_add(x.wrapping_mul(LCG_MULTIPLIER));
    [x ^ (x >> 16), y ^ (y >> 16)]
}

/// Hash of three numbers to three, a bijection: `pcg3d` of Jarzynski and Olano 2020. Their choice for speed
/// and quality.
#[must_use]
#[inline]
pub const fn pcg3d([mut x, mut y, mut z]: [u32; 3]) -> [u32; 3] {
    x = lcg(x);
    y = lcg(y);
    z = lcg(z);
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    x ^= x >> 16;
    y ^= y >> 16;
    z ^= z >> 16;
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    [x, y, z]
}

/// Hash of four numbers to four, a bijection: `pcg4d` of Jarzynski and Olano 2020.
#[must_use]
pub const fn pcg4d([mut x, mut y, mut z, mut w]: [u32; 4]) -> [u32; 4] {
    x = lcg(x);
    y = lcg(y);
    z = lcg(z);
    w = lcg(w);
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    x ^= x >> 16;
    y ^= y >> 16;
    z ^= z >> 16;
    w ^= w >> 16;
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    [x, y, z, w]
}

#[inline]
const fn lcg(v: u32) -> u32 {
    v.wrapping_mul(LCG_MULTIPLIER).wrapping_add(LCG_INCREMENT)
}

/// Random bits as a number in [0, 1): the top 24 bits, which a 32-bit float holds exactly, so that 1 never
/// comes out.
#[must_use]
#[inline]
pub const fn unit_from_bits(bits: u32) -> f32 {
    (bits >> 8) as f32 * UNIT_STEP
}

/// FNV-1a of 64 bits (Fowler, Noll, Vo): a fingerprint that tells contents apart and pins tables in tests, no
/// random source.
#[derive(Clone, Copy, Debug)]
pub struct Fnv1a(u64);

impl Fnv1a {
    /// The fingerprint of nothing: the authors' offset basis.
    pub const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    /// Adds bytes behind all that came before.
    pub fn add(&mut self, bytes: impl IntoIterator<Item = u8>) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// The fingerprint of all bytes so far.
    #[must_use]
    pub fn value(self) -> u64 {
        self.0
    }
}

/// [`Fnv1a`] of some bytes.
#[must_use]
pub fn fnv1a(bytes: impl IntoIterator<Item = u8>) -> u64 {
    let mut hash = Fnv1a::EMPTY;
    hash.add(bytes);
    hash.value()
}

/// How much [`mcguire2`] blows up its sines, as the listing has it.
pub const MCGUIRE_GAIN: f32 = 1.0e4;
/// Factor of x in the first sine of [`mcguire2`].
pub const MCGUIRE_X: f32 = 17.0;
/// Factor of y in the first sine of [`mcguire2`].
pub const MCGUIRE_Y: f32 = 0.1;
/// Factor of y in the second sine of [`mcguire2`].
pub const MCGUIRE_Y_OF_WEIGHT: f32 = 13.0;
/// Least weight of the first sine of [`mcguire2`].
pub const MCGUIRE_LEAST: f32 = 0.1;

/// McGuire's hash of two numbers to [0, 1) (*The Graphics Codex* 2.13; STD appendix, Listing 6 `hash`).
///
/// It rests on the platform's `sin`, so that its bits differ between machines, and degrades for large
/// arguments; the `pcg` family is the default for both reasons.
#[must_use]
pub fn mcguire2(v: Vec2) -> f32 {
    let weight = MCGUIRE_LEAST + (MCGUIRE_Y_OF_WEIGHT * v.y + v.x).sin().abs();
    fract_below_one(MCGUIRE_GAIN * (MCGUIRE_X * v.x + MCGUIRE_Y * v.y).sin() * weight)
}

/// McGuire's hash of three numbers to [0, 1) (STD appendix, Listing 6 `hash3D`).
#[must_use]
pub fn mcguire3(v: Vec3) -> f32 {
    mcguire2(Vec2::new(mcguire2(v.truncate()), v.z))
}

/// McGuire's hash of four numbers to [0, 1) (STD appendix, Listing 6 `hash4D`).
#[must_use]
pub fn mcguire4(v: Vec4) -> f32 {
    mcguire2(Vec2::new(mcguire2(Vec2::new(v.x, v.y)), mcguire2(Vec2::new(v.z, v.w))))
}

/// `frac` of the listing. A tiny negative number rounds to 1, which would index past the end of a table: cut
/// below 1.
fn fract_below_one(v: f32) -> f32 {
    (v - v.floor()).min(BELOW_ONE)
}

/// Step of SplitMix64 (Steele, Lea and Flood 2014).
pub const SPLITMIX64_STEP: u64 = 0x9e37_79b9_7f4a_7c15;
/// Multipliers of its output function.
pub const SPLITMIX64_FACTORS: [u64; 2] = [0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb];
/// Multiplier of the step of [`Pcg32`] (O'Neill 2014).
pub const PCG32_MULTIPLIER: u64 = 6_364_136_223_846_793_005;

/// The output function of SplitMix64 after one step (Steele, Lea and Flood 2014), a bijection.
const fn splitmix64(v: u64) -> u64 {
    let v = v.wrapping_add(SPLITMIX64_STEP);
    let v = (v ^ (v >> 30)).wrapping_mul(SPLITMIX64_FACTORS[0]);
    let v = (v ^ (v >> 27)).wrapping_mul(SPLITMIX64_FACTORS[1]);
    v ^ (v >> 31)
}

/// A small random stream for building scenes and for tests: PCG XSH-RR 64/32 (O'Neill 2014).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pcg32 {
    state: u64,
    increment: u64,
}

impl Pcg32 {
    /// The stream number `stream` of the family `seed`.
    ///
    /// Both pass through SplitMix64: two bare PCG streams that start from the same state are visibly
    /// correlated.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        let mixed = splitmix64(splitmix64(seed).wrapping_add(stream));
        Self::from_state(mixed, splitmix64(mixed))
    }

    /// The reference implementation's way to start: `pcg32_srandom_r`.
    fn from_state(state: u64, sequence: u64) -> Self {
        let mut random = Self { state: 0, increment: sequence << 1 | 1 };
        random.next_u32();
        random.state = random.state.wrapping_add(state);
        random.next_u32();
        random
    }

    /// The next 32 random bits.
    pub fn next_u32(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(PCG32_MULTIPLIER).wrapping_add(self.increment);
        let shifted = (((old >> 18) ^ old) >> 27) as u32;
        shifted.rotate_right((old >> 59) as u32)
    }

    /// The next number in [0, 1).
    pub fn next_f32(&mut self) -> f32 {
        unit_from_bits(self.next_u32())
    }

    /// The next number from `low` to `high`; rounding may give `high` itself.
    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next_f32()
    }

    /// The next whole number in `0..count`, each equally likely; 0 if `count` is 0.
    ///
    /// Multiplication with rejection (Lemire, *Fast Random Integer Generation in an Interval*, 2019).
    pub fn below(&mut self, count: u32) -> u32 {
        let unfair = count.wrapping_neg().checked_rem(count).unwrap_or(0);
        loop {
            let product = u64::from(self.next_u32()) * u64::from(count);
            if product as u32 >= unfair {
                return (product >> 32) as u32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BINS: usize = 256;

    /// How many standard deviations the chi-square statistic of equally likely bins lies above its mean.
    fn chi_square_z(values: impl Iterator<Item = f32>) -> f64 {
        let mut counts = [0_u32; BINS];
        for value in values {
            assert!((0.0..1.0).contains(&value), "{value} lies outside [0, 1)");
            counts[(value * BINS as f32) as usize] += 1;
        }
        let expected = f64::from(counts.iter().sum::<u32>()) / BINS as f64;
        let chi_square: f64 =
            counts.iter().map(|&count| (f64::from(count) - expected).powi(2) / expected).sum();
        let freedom = (BINS - 1) as f64;
        (chi_square - freedom) / (2.0 * freedom).sqrt()
    }

    /// Four standard deviations: chance exceeds it about once in 10,000 tests, and the inputs are fixed.
    const Z_LIMIT: f64 = 4.0;
    const SIDE: u32 = 256;

    fn grid() -> impl Iterator<Item = (u32, u32)> {
        (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE))
    }

    #[test]
    fn hashes_agree_with_the_published_definition() {
        // Worked out with Python integers modulo 2^32 from the listings of the paper.
        assert_eq!([0, 1, 2, u32::MAX].map(pcg), [0x07bb_2fe2, 0xa8be_ea3c, 0x7a7e_cc88, 0xe62a_4902]);
        assert_eq!(pcg2d([0, 0]), [0x18e4_31a7, 0x055d_f4d1]);
        assert_eq!(pcg2d([1, 2]), [0x02bb_3f0c, 0x0cc2_73a5]);
        assert_eq!(pcg3d([0, 0, 0]), [0x9baf_d7c6, 0xa8e8_8a6b, 0x3f15_482c]);
        assert_eq!(pcg3d([1, 2, 3]), [0xfa9f_79a6, 0x48f2_f44c, 0x596f_5ab1]);
        assert_eq!(pcg4d([0, 0, 0, 0]), [0x0f02_f829, 0x2d56_8769, 0x32b0_c43b, 0xd325_48ea]);
        assert_eq!(pcg4d([1, 2, 3, u32::MAX]), [0xda80_bf0b, 0x318e_eeff, 0xa727_61e3, 0x24db_78e8]);
    }

    #[test]
    fn the_stream_agrees_with_the_reference_implementation() {
        // The first numbers that the demo of the PCG library prints for seed 42, stream 54.
        let mut random = Pcg32::from_state(42, 54);
        let first = [0xa15c_02b7, 0x7b47_f409, 0xba1d_3330, 0x83d2_f293, 0xbfa4_784b, 0xcbed_606e];
        assert_eq!([(); 6].map(|()| random.next_u32()), first);
    }

    #[test]
    fn unit_numbers_reach_neither_one_nor_below_zero() {
        assert_eq!(unit_from_bits(0), 0.0);
        assert_eq!(unit_from_bits(u32::MAX), 1.0_f32.next_down());
        assert_eq!(unit_from_bits(1 << 31), 0.5);
        assert_eq!(fract_below_one(-1e-9), 1.0_f32.next_down());
        assert_eq!(fract_below_one(-0.25), 0.75);
    }

    #[test]
    fn every_hash_is_uniform_over_a_pixel_grid() {
        type PixelHash = fn(u32, u32) -> u32;
        let all: [(&str, PixelHash); 9] = [
            ("pcg", |x, y| pcg(SIDE * y + x)),
            ("pcg2d.x", |x, y| pcg2d([x, y])[0]),
            ("pcg2d.y", |x, y| pcg2d([x, y])[1]),
            ("pcg3d.x", |x, y| pcg3d([x, y, 7])[0]),
            ("pcg3d.y", |x, y| pcg3d([x, y, 7])[1]),
            ("pcg3d.z", |x, y| pcg3d([x, y, 7])[2]),
            ("pcg4d.x", |x, y| pcg4d([x, y, 7, 11])[0]),
            ("pcg4d.y", |x, y| pcg4d([x, y, 7, 11])[1]),
            ("pcg4d.w", |x, y| pcg4d([x, y, 7, 11])[3]),
        ];
        for (name, hash) in all {
            let z = chi_square_z(grid().map(|(x, y)| unit_from_bits(hash(x, y))));
            assert!(z.abs() < Z_LIMIT, "{name}: z = {z}");
        }
    }

    #[test]
    fn neighbouring_pixels_and_frames_hash_independently() {
        // Bins of pairs: four bits from the site, four from its neighbour.
        let pair = |a: u32, b: u32| unit_from_bits((a >> 28 << 28) | (b >> 28 << 24));
        for (name, step) in [("right", [1, 0, 0]), ("down", [0, 1, 0]), ("next frame", [0, 0, 1])] {
            let at = |x, y| pair(pcg3d([x, y, 3])[0], pcg3d([x + step[0], y + step[1], 3 + step[2]])[0]);
            let z = chi_square_z(grid().map(|(x, y)| at(x, y)));
            assert!(z.abs() < Z_LIMIT, "{name}: z = {z}");
        }
    }

    #[test]
    fn mcguires_hashes_are_roughly_uniform_at_random_places() {
        // Small arguments, where the hash is meant to be used. Its flaws show beyond a few hundred thousand
        // samples.
        let mut random = Pcg32::new(1, 0);
        let places: Vec<[f32; 4]> =
            (0..SIDE * SIDE).map(|_| [(); 4].map(|()| random.range(0.0, 10.0))).collect();
        type PlaceHash = fn(Vec4) -> f32;
        let hashes: [(&str, PlaceHash); 3] = [
            ("mcguire2", |v| mcguire2(v.truncate().truncate())),
            ("mcguire3", |v| mcguire3(v.truncate())),
            ("mcguire4", mcguire4),
        ];
        for (name, hash) in hashes {
            let z = chi_square_z(places.iter().map(|&place| hash(Vec4::from_array(place))));
            assert!(z.abs() < Z_LIMIT, "{name}: z = {z}");
        }
    }

    #[test]
    fn the_uniformity_test_rejects_a_counter_and_a_slightly_skewed_source() {
        assert!(chi_square_z(grid().map(|(x, y)| unit_from_bits(SIDE * y + x))) > 100.0);
        let mut random = Pcg32::new(2, 0);
        assert!(chi_square_z((0..SIDE * SIDE).map(|_| random.next_f32().powf(1.1))) > Z_LIMIT);
    }

    /// Bins of pairs: the top four bits of both streams.
    fn pairs(mut a: Pcg32, mut b: Pcg32) -> impl Iterator<Item = f32> {
        (0..1 << 16).map(move |_| unit_from_bits((a.next_u32() >> 28 << 28) | (b.next_u32() >> 28 << 24)))
    }

    #[test]
    fn the_stream_is_uniform_and_streams_are_unlike() {
        let mut random = Pcg32::new(0, 0);
        assert!(chi_square_z((0..1 << 16).map(|_| random.next_f32())).abs() < Z_LIMIT);
        for (a, b) in [((0, 1), (0, 2)), ((0, 1), (1, 1)), ((0, 1), (1, 0)), ((7, 0), (7, 1 << 63))] {
            let z = chi_square_z(pairs(Pcg32::new(a.0, a.1), Pcg32::new(b.0, b.1)));
            assert!(z.abs() < Z_LIMIT, "{a:?} and {b:?}: z = {z}");
        }
    }

    #[test]
    fn the_independence_test_rejects_bare_streams_of_one_state() {
        assert!(chi_square_z(pairs(Pcg32::from_state(0, 1), Pcg32::from_state(0, 2))) > Z_LIMIT);
    }

    #[test]
    fn whole_numbers_below_a_count_are_equally_likely() {
        let mut random = Pcg32::new(3, 0);
        let mut counts = [0_u32; 288];
        (0..288 * 400).for_each(|_| counts[random.below(288) as usize] += 1);
        let chi_square: f64 = counts.iter().map(|&count| (f64::from(count) - 400.0).powi(2) / 400.0).sum();
        assert!((chi_square - 287.0).abs() < Z_LIMIT * (2.0 * 287.0_f64).sqrt(), "{chi_square}");
        assert_eq!((random.below(0), random.below(1)), (0, 0));
        assert!((0..100).all(|_| (2.0..=3.0).contains(&random.range(2.0, 3.0))));
    }
}
