//! AVX2 and AVX-512 lanes.
//!
//! Both use 256-bit registers: eight lanes are one. AVX-512 brings comparisons straight into masks,
//! operands broadcast from memory, and twice the registers.

use std::arch::x86_64::{
    __m256, __m256i, _CMP_LE_OQ, _CMP_LT_OQ, _MM_HINT_T0, _mm_prefetch, _mm256_add_ps, _mm256_andnot_si256,
    _mm256_blend_epi32, _mm256_castps_si256, _mm256_cmp_ps, _mm256_cmp_ps_mask, _mm256_cmpeq_epi32,
    _mm256_div_ps, _mm256_loadu_ps, _mm256_loadu_si256, _mm256_mask_blend_epi32, _mm256_max_epu32,
    _mm256_max_ps, _mm256_min_epu32, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_or_si256,
    _mm256_permute2f128_ps, _mm256_permutevar8x32_epi32, _mm256_set1_epi32, _mm256_set1_ps,
    _mm256_setr_epi32, _mm256_shuffle_epi32, _mm256_shuffle_ps, _mm256_storeu_ps, _mm256_storeu_si256,
    _mm256_sub_ps, _mm256_unpackhi_ps, _mm256_unpacklo_ps, _mm256_xor_si256,
};

use super::lanes::Lanes;
use super::stack::Stack;
use crate::column::{self, Column};
use crate::instance::TopLevel;
use crate::node::{Child, WIDTH};
use crate::packet;
use crate::ray::{Hit, Ray};
use crate::traverse;
use crate::tree::Tree;

pub(super) fn has_avx512() -> bool {
    has_avx2()
        && is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
}

pub(super) fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt")
}

/// [`traverse::traverse`] with AVX-512 instructions; everything below it is inlined here.
#[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn traverse_avx512<const IN_ORDER: bool>(
    tree: Tree<'_>,
    ray: &Ray,
    visit: impl FnMut(Hit) -> f32,
) {
    traverse::traverse::<IN_ORDER, _>(Avx512(()), tree, ray, visit);
}

/// [`traverse::traverse`] with AVX2 instructions; everything below it is inlined here.
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn traverse_avx2<const IN_ORDER: bool>(tree: Tree<'_>, ray: &Ray, visit: impl FnMut(Hit) -> f32) {
    traverse::traverse::<IN_ORDER, _>(Avx2(()), tree, ray, visit);
}

/// [`traverse::traverse_two_levels`] with AVX-512 instructions.
#[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn traverse_two_levels_avx512(
    tree: Tree<'_>,
    top: &TopLevel,
    ray: &Ray,
    visit: &mut dyn FnMut(Hit) -> f32,
) {
    traverse::traverse_two_levels(Avx512(()), tree, top, ray, visit);
}

/// [`traverse::traverse_two_levels`] with AVX2 instructions.
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn traverse_two_levels_avx2(
    tree: Tree<'_>,
    top: &TopLevel,
    ray: &Ray,
    visit: &mut dyn FnMut(Hit) -> f32,
) {
    traverse::traverse_two_levels(Avx2(()), tree, top, ray, visit);
}

/// [`packet::traverse`] with AVX-512 instructions; everything below it but the set-up is inlined here.
#[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn traverse_packet_avx512(tree: Tree<'_>, rays: &[Ray], visit: impl FnMut(usize, Hit) -> f32) {
    packet::traverse(Avx512(()), tree, rays, visit);
}

/// [`packet::traverse`] with AVX2 instructions; everything below it but the set-up is inlined here.
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn traverse_packet_avx2(tree: Tree<'_>, rays: &[Ray], visit: impl FnMut(usize, Hit) -> f32) {
    packet::traverse(Avx2(()), tree, rays, visit);
}

/// [`packet::traverse_two_levels`] with AVX-512 instructions.
#[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn traverse_packet_two_levels_avx512(
    tree: Tree<'_>,
    top: &TopLevel,
    rays: &[Ray],
    visit: &mut dyn FnMut(usize, Hit) -> f32,
) {
    packet::traverse_two_levels(Avx512(()), tree, top, rays, visit);
}

/// [`packet::traverse_two_levels`] with AVX2 instructions.
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn traverse_packet_two_levels_avx2(
    tree: Tree<'_>,
    top: &TopLevel,
    rays: &[Ray],
    visit: &mut dyn FnMut(usize, Hit) -> f32,
) {
    packet::traverse_two_levels(Avx2(()), tree, top, rays, visit);
}

/// [`column::scan`] with AVX-512 instructions; everything below it is inlined here.
#[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn scan_avx512(column: &Column<'_>, t_max: f32, visit: impl FnMut(Hit) -> f32) {
    column::scan(Avx512(()), column, t_max, visit);
}

/// [`column::scan`] with AVX2 instructions; everything below it is inlined here.
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn scan_avx2(column: &Column<'_>, t_max: f32, visit: impl FnMut(Hit) -> f32) {
    column::scan(Avx2(()), column, t_max, visit);
}

/// Made only inside the functions for AVX-512, which need the features.
#[derive(Clone, Copy)]
struct Avx512(());

/// Made only inside the functions for AVX2, which need the features.
#[derive(Clone, Copy)]
struct Avx2(());

/// Bytes.
const CACHE_LINE: usize = 64;

/// An intrinsic inside a method of [`Avx512`] or [`Avx2`].
macro_rules! x86 {
    ($intrinsic:expr) => {{
        // SAFETY: a value of the type exists only in a function that enables its features (see there), and
        // the unaligned loads and stores take references to eight elements.
        unsafe { $intrinsic }
    }};
}

/// What the two paths share.
macro_rules! arithmetic {
    () => {
        type F = __m256;

        #[inline(always)]
        fn load(self, values: &[f32; WIDTH]) -> __m256 {
            x86!(_mm256_loadu_ps(values.as_ptr()))
        }

        #[inline(always)]
        fn splat(self, value: f32) -> __m256 {
            x86!(_mm256_set1_ps(value))
        }

        #[inline(always)]
        fn store(self, values: __m256) -> [f32; WIDTH] {
            let mut array = [0.0; WIDTH];
            x86!(_mm256_storeu_ps(array.as_mut_ptr(), values));
            array
        }

        #[inline(always)]
        fn add(self, a: __m256, b: __m256) -> __m256 {
            x86!(_mm256_add_ps(a, b))
        }

        #[inline(always)]
        fn sub(self, a: __m256, b: __m256) -> __m256 {
            x86!(_mm256_sub_ps(a, b))
        }

        #[inline(always)]
        fn mul(self, a: __m256, b: __m256) -> __m256 {
            x86!(_mm256_mul_ps(a, b))
        }

        #[inline(always)]
        fn div(self, a: __m256, b: __m256) -> __m256 {
            x86!(_mm256_div_ps(a, b))
        }

        #[inline(always)]
        fn min(self, a: __m256, b: __m256) -> __m256 {
            x86!(_mm256_min_ps(a, b))
        }

        #[inline(always)]
        fn max(self, a: __m256, b: __m256) -> __m256 {
            x86!(_mm256_max_ps(a, b))
        }

        #[inline(always)]
        fn transpose(self, rows: [__m256; WIDTH]) -> [__m256; WIDTH] {
            x86!(transpose(rows))
        }

        #[inline(always)]
        fn prefetch<T>(self, value: &T) {
            let start = std::ptr::from_ref(value).cast::<i8>();
            for line in 0..size_of::<T>().div_ceil(CACHE_LINE) {
                x86!(_mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line * CACHE_LINE)));
            }
        }

        #[inline(always)]
        fn push(self, stack: &mut Stack<'_>, near: __m256, hits: u32, children: &[Child; WIDTH]) {
            let keys = x86!({
                let lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
                let near = _mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_castps_si256(near));
                _mm256_xor_si256(_mm256_or_si256(near, lane), _mm256_set1_epi32(-1))
            });
            // Lanes that were not hit sort behind all others, above the new top of the stack.
            let sorted = x86!(sort(self.keep(keys, hits)));
            x86!({
                let bits = _mm256_xor_si256(sorted, _mm256_set1_epi32(-1));
                let near = _mm256_andnot_si256(_mm256_set1_epi32(7), bits);
                // The permutation reads the lowest three bits of each index only.
                let children =
                    _mm256_permutevar8x32_epi32(_mm256_loadu_si256(children.as_ptr().cast()), bits);
                let (near_slots, child_slots) = stack.reserve();
                _mm256_storeu_si256(near_slots.cast(), near);
                _mm256_storeu_si256(child_slots.cast(), children);
                stack.grow(hits.count_ones() as usize);
            });
        }
    };
}

impl Lanes for Avx512 {
    arithmetic!();

    #[inline(always)]
    fn le(self, a: __m256, b: __m256) -> u32 {
        u32::from(x86!(_mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b)))
    }

    #[inline(always)]
    fn lt(self, a: __m256, b: __m256) -> u32 {
        u32::from(x86!(_mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b)))
    }
}

impl Avx512 {
    /// The keys of the lanes in `hits`, all ones elsewhere.
    #[inline(always)]
    fn keep(self, keys: __m256i, hits: u32) -> __m256i {
        x86!(_mm256_mask_blend_epi32(hits as u8, _mm256_set1_epi32(-1), keys))
    }
}

impl Lanes for Avx2 {
    arithmetic!();

    #[inline(always)]
    fn le(self, a: __m256, b: __m256) -> u32 {
        x86!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32)
    }

    #[inline(always)]
    fn lt(self, a: __m256, b: __m256) -> u32 {
        x86!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) as u32)
    }
}

impl Avx2 {
    /// The keys of the lanes in `hits`, all ones elsewhere.
    #[inline(always)]
    fn keep(self, keys: __m256i, hits: u32) -> __m256i {
        x86!({
            let bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let missed = _mm256_andnot_si256(_mm256_set1_epi32(hits as i32), bit);
            _mm256_or_si256(keys, _mm256_cmpeq_epi32(missed, bit))
        })
    }
}

/// Sorts eight unsigned numbers, smallest in lane 0: a bitonic network of six stages, about 20 cycles and
/// not one branch to mispredict.
#[inline]
#[target_feature(enable = "avx2")]
fn sort(x: __m256i) -> __m256i {
    /// Compares each lane with its partner; `UPPER` marks the lanes that keep the larger.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn exchange<const UPPER: i32>(x: __m256i, partner: __m256i) -> __m256i {
        _mm256_blend_epi32::<UPPER>(_mm256_min_epu32(x, partner), _mm256_max_epu32(x, partner))
    }
    let x = exchange::<0b1010_1010>(x, _mm256_shuffle_epi32::<0b10_11_00_01>(x));
    let x = exchange::<0b1100_1100>(x, _mm256_shuffle_epi32::<0b00_01_10_11>(x));
    let x = exchange::<0b1010_1010>(x, _mm256_shuffle_epi32::<0b10_11_00_01>(x));
    let reversed = _mm256_permutevar8x32_epi32(x, _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0));
    let x = exchange::<0b1111_0000>(x, reversed);
    let x = exchange::<0b1100_1100>(x, _mm256_shuffle_epi32::<0b01_00_11_10>(x));
    exchange::<0b1010_1010>(x, _mm256_shuffle_epi32::<0b10_11_00_01>(x))
}

/// An 8 × 8 matrix by its columns: pairs, quads, halves.
#[inline]
#[target_feature(enable = "avx")]
fn transpose([a, b, c, d, e, f, g, h]: [__m256; WIDTH]) -> [__m256; WIDTH] {
    let pairs = [
        _mm256_unpacklo_ps(a, b),
        _mm256_unpackhi_ps(a, b),
        _mm256_unpacklo_ps(c, d),
        _mm256_unpackhi_ps(c, d),
        _mm256_unpacklo_ps(e, f),
        _mm256_unpackhi_ps(e, f),
        _mm256_unpacklo_ps(g, h),
        _mm256_unpackhi_ps(g, h),
    ];
    let quads = [
        _mm256_shuffle_ps::<0b01_00_01_00>(pairs[0], pairs[2]),
        _mm256_shuffle_ps::<0b11_10_11_10>(pairs[0], pairs[2]),
        _mm256_shuffle_ps::<0b01_00_01_00>(pairs[1], pairs[3]),
        _mm256_shuffle_ps::<0b11_10_11_10>(pairs[1], pairs[3]),
        _mm256_shuffle_ps::<0b01_00_01_00>(pairs[4], pairs[6]),
        _mm256_shuffle_ps::<0b11_10_11_10>(pairs[4], pairs[6]),
        _mm256_shuffle_ps::<0b01_00_01_00>(pairs[5], pairs[7]),
        _mm256_shuffle_ps::<0b11_10_11_10>(pairs[5], pairs[7]),
    ];
    [
        _mm256_permute2f128_ps::<0x20>(quads[0], quads[4]),
        _mm256_permute2f128_ps::<0x20>(quads[1], quads[5]),
        _mm256_permute2f128_ps::<0x20>(quads[2], quads[6]),
        _mm256_permute2f128_ps::<0x20>(quads[3], quads[7]),
        _mm256_permute2f128_ps::<0x31>(quads[0], quads[4]),
        _mm256_permute2f128_ps::<0x31>(quads[1], quads[5]),
        _mm256_permute2f128_ps::<0x31>(quads[2], quads[6]),
        _mm256_permute2f128_ps::<0x31>(quads[3], quads[7]),
    ]
}
