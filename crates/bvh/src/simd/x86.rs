//! Eight lanes as one AVX register.
#![expect(unsafe_code, reason = "vector instructions, guarded by values that prove their support")]

use super::{Simd, StackEntry, WithSimd, order_by_insertion};
use crate::node::{Child, WIDTH};
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

/// Proof that the processor supports AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

impl Avx2 {
    pub(crate) fn new() -> Option<Self> {
        (is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt"))
        .then_some(Self(()))
    }
}

/// Proof that the processor supports the features of [`Avx2`] and AVX-512 F, VL, DQ and BW.
///
/// Only 256-bit registers are used, since a node has eight children. The advantages over AVX2 are
/// mask registers, twice as many vector registers and the compress instruction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512(());

impl Avx512 {
    pub(crate) fn new() -> Option<Self> {
        (Avx2::new().is_some()
            && is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512bw"))
        .then_some(Self(()))
    }
}

/// Safe methods over intrinsics.
macro_rules! intrinsics {
    ($($name:ident($($a:ident),*) => $intrinsic:expr;)*) => {$(
        #[inline(always)]
        fn $name(self, $($a: Self::Lanes),*) -> Self::Lanes {
            // SAFETY: `self` proves that the processor supports the instruction.
            unsafe { $intrinsic }
        }
    )*};
}

/// A comparison of all lanes, as a bit mask.
macro_rules! mask {
    (in_vectors, $predicate:ident, $a:ident, $b:ident) => {
        _mm256_movemask_ps(_mm256_cmp_ps::<$predicate>($a, $b)) as u32
    };
    (in_masks, $predicate:ident, $a:ident, $b:ident) => {
        u32::from(_mm256_cmp_ps_mask::<$predicate>($a, $b))
    };
}

macro_rules! implement {
    ($isa:ident, $features:literal, $masks:ident) => {
        impl Simd for $isa {
            type Lanes = __m256;

            #[inline(always)]
            fn run<T: WithSimd>(self, task: T) -> T::Output {
                #[target_feature(enable = $features)]
                fn compiled<T: WithSimd>(simd: $isa, task: T) -> T::Output {
                    task.run(simd)
                }
                // SAFETY: `self` proves that the processor supports the features.
                unsafe { compiled(self, task) }
            }

            #[inline(always)]
            fn run_outlined<T: WithSimd>(self, task: T) -> T::Output {
                #[target_feature(enable = $features)]
                fn compiled<T: WithSimd>(simd: $isa, task: T) -> T::Output {
                    task.run(simd)
                }
                // A function of its own, because rustc 1.95 ignores `inline(never)` on functions
                // with target features.
                #[inline(never)]
                fn outlined<T: WithSimd>(simd: $isa, task: T) -> T::Output {
                    // SAFETY: `simd` proves that the processor supports the features.
                    unsafe { compiled(simd, task) }
                }
                outlined(self, task)
            }

            #[inline(always)]
            fn prefetch<T>(self, value: &T) {
                let start = std::ptr::from_ref(value).cast::<i8>();
                for line in 0..size_of::<T>().div_ceil(64) {
                    // SAFETY: x86-64 includes SSE, and a prefetch does not access memory.
                    unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(64 * line)) };
                }
            }

            #[inline(always)]
            fn load(self, from: &[f32; WIDTH]) -> __m256 {
                // SAFETY: `self` proves AVX; the array holds eight floats, and the load is
                // unaligned.
                unsafe { _mm256_loadu_ps(from.as_ptr()) }
            }

            #[inline(always)]
            fn splat(self, value: f32) -> __m256 {
                // SAFETY: `self` proves AVX.
                unsafe { _mm256_set1_ps(value) }
            }

            #[inline(always)]
            fn to_array(self, a: __m256) -> [f32; WIDTH] {
                let mut array = [0.0; WIDTH];
                // SAFETY: `self` proves AVX; the array holds eight floats.
                unsafe { _mm256_storeu_ps(array.as_mut_ptr(), a) };
                array
            }

            intrinsics! {
                add(a, b) => _mm256_add_ps(a, b);
                sub(a, b) => _mm256_sub_ps(a, b);
                mul(a, b) => _mm256_mul_ps(a, b);
                div(a, b) => _mm256_div_ps(a, b);
                sqrt(a) => _mm256_sqrt_ps(a);
                mul_add(a, b, c) => _mm256_fmadd_ps(a, b, c);
                neg_mul_add(a, b, c) => _mm256_fnmadd_ps(a, b, c);
                abs(a) => _mm256_and_ps(a, _mm256_castsi256_ps(_mm256_set1_epi32(i32::MAX)));
                times_sign_of(a, sign) =>
                    _mm256_xor_ps(a, _mm256_and_ps(sign, _mm256_set1_ps(-0.0)));
                nan_unless_le(x, a, b) =>
                    _mm256_or_ps(x, _mm256_cmp_ps::<_CMP_NLE_UQ>(a, b));
                min(a, b) => _mm256_min_ps(a, b);
                max(a, b) => _mm256_max_ps(a, b);
            }

            #[inline(always)]
            fn mask_le(self, a: __m256, b: __m256) -> u32 {
                // SAFETY: `self` proves that the processor supports the instruction.
                unsafe { mask!($masks, _CMP_LE_OQ, a, b) }
            }

            #[inline(always)]
            fn mask_not_gt(self, a: __m256, b: __m256) -> u32 {
                // SAFETY: `self` proves that the processor supports the instruction.
                unsafe { mask!($masks, _CMP_NGT_UQ, a, b) }
            }

            #[inline(always)]
            fn order(
                self,
                near: __m256,
                mask: u32,
                children: &[Child; WIDTH],
                out: &mut [MaybeUninit<StackEntry>; WIDTH],
            ) {
                if mask.count_ones() > 4 {
                    return order_by_insertion(self.to_array(near), mask, children, out);
                }
                // SAFETY: `self` proves that the processor supports the instructions. `children`
                // has the layout of eight integers and `out` has room for four entries of 64 bits.
                unsafe {
                    // The lane replaces the lowest three bits of the distance. The slack of the
                    // limit covers this error.
                    let distance = _mm256_castps_si256(_mm256_max_ps(near, _mm256_setzero_ps()));
                    let lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
                    let keys =
                        _mm256_or_si256(_mm256_andnot_si256(_mm256_set1_epi32(7), distance), lanes);
                    let sorted = sort_descending(self.compress(keys, mask));
                    let children = _mm256_loadu_si256(children.as_ptr().cast());
                    let children = _mm256_castsi256_si128(_mm256_permutevar8x32_epi32(
                        children,
                        _mm256_castsi128_si256(sorted),
                    ));
                    let to = out.as_mut_ptr().cast::<__m128i>();
                    _mm_storeu_si128(to, _mm_unpacklo_epi32(children, sorted));
                    _mm_storeu_si128(to.add(1), _mm_unpackhi_epi32(children, sorted));
                }
            }
        }
    };
}

implement!(Avx2, "avx2,fma,bmi1,bmi2,lzcnt,popcnt", in_vectors);
implement!(Avx512, "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw", in_masks);

/// A sorting network (0 2)(1 3), (0 1)(2 3), (1 2), which moves larger keys to lower lanes.
///
/// # Safety
///
/// The processor must support SSE4.1.
#[inline(always)]
unsafe fn sort_descending(keys: __m128i) -> __m128i {
    // SAFETY: the caller guarantees the support of the instructions.
    unsafe {
        let other = _mm_shuffle_epi32::<0b01_00_11_10>(keys);
        let (large, small) = (_mm_max_epu32(keys, other), _mm_min_epu32(keys, other));
        let keys = _mm_blend_epi16::<0b1111_0000>(large, small);
        let other = _mm_shuffle_epi32::<0b10_11_00_01>(keys);
        let (large, small) = (_mm_max_epu32(keys, other), _mm_min_epu32(keys, other));
        let keys = _mm_blend_epi16::<0b1100_1100>(large, small);
        let other = _mm_shuffle_epi32::<0b11_01_10_00>(keys);
        let (large, small) = (_mm_max_epu32(keys, other), _mm_min_epu32(keys, other));
        let keys = _mm_blend_epi16::<0b0000_1100>(keys, large);
        _mm_blend_epi16::<0b0011_0000>(keys, small)
    }
}

impl Avx2 {
    /// The keys in `mask`, at most four, in the first lanes; zero in the others.
    #[inline(always)]
    fn compress(self, keys: __m256i, mask: u32) -> __m128i {
        let [lanes, kept] = PACKED[mask as usize % 256];
        // SAFETY: `self` proves AVX2.
        unsafe {
            let lanes = _mm256_cvtepu8_epi32(_mm_cvtsi32_si128(lanes as i32));
            let packed = _mm256_castsi256_si128(_mm256_permutevar8x32_epi32(keys, lanes));
            _mm_and_si128(packed, _mm_cvtepi8_epi32(_mm_cvtsi32_si128(kept as i32)))
        }
    }
}

/// For each mask, the indices of its first four lanes, one byte each, and a byte mask of how many
/// of the four exist.
static PACKED: [[u32; 2]; 256] = {
    let mut table = [[0; 2]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 && count < 4 {
            if mask >> lane & 1 == 1 {
                table[mask][0] |= lane << (8 * count);
                table[mask][1] |= 255 << (8 * count);
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

impl Avx512 {
    /// The keys in `mask`, at most four, in the first lanes; zero in the others.
    #[inline(always)]
    fn compress(self, keys: __m256i, mask: u32) -> __m128i {
        // SAFETY: `self` proves AVX-512 F and VL.
        unsafe { _mm256_castsi256_si128(_mm256_maskz_compress_epi32(mask as u8, keys)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Portable;

    fn ordered(simd: impl Simd, near: &[f32; 8], mask: u32, children: &[Child; 8]) -> Vec<Child> {
        let mut out = [MaybeUninit::new(StackEntry(u64::MAX)); 8];
        simd.order(simd.load(near), mask, children, &mut out);
        // SAFETY: all entries were initialized above.
        out[..mask.count_ones() as usize]
            .iter()
            .map(|e| unsafe { e.assume_init() }.child())
            .collect()
    }

    #[test]
    fn every_mask_is_ordered_as_by_the_portable_version() {
        let near = [3.0, -1.0, 0.5, 1e30, 0.25, f32::INFINITY, 7.0, 2.0];
        let children = [10, 11, 12, 13, 14, 15, 16, 17].map(Child::leaf);
        for mask in 0..256 {
            let expected = ordered(Portable, &near, mask, &children);
            if let Some(simd) = Avx2::new() {
                assert_eq!(ordered(simd, &near, mask, &children), expected, "{mask:#b}");
            }
            if let Some(simd) = Avx512::new() {
                assert_eq!(ordered(simd, &near, mask, &children), expected, "{mask:#b}");
            }
        }
    }

    #[test]
    fn minimum_and_maximum_return_their_second_argument_beside_a_nan() {
        fn check(simd: impl Simd) {
            let (nan, one) = (simd.splat(f32::NAN), simd.splat(1.0));
            assert_eq!(simd.to_array(simd.min(nan, one)), [1.0; 8]);
            assert_eq!(simd.to_array(simd.max(nan, one)), [1.0; 8]);
            assert!(simd.to_array(simd.min(one, nan))[0].is_nan());
            assert!(simd.to_array(simd.max(one, nan))[7].is_nan());
            assert_eq!(simd.mask_le(nan, one) | simd.mask_le(one, nan), 0);
            assert_eq!(simd.mask_le(one, one), 255);
        }
        check(Portable);
        if let Some(simd) = Avx2::new() {
            check(simd);
        }
        if let Some(simd) = Avx512::new() {
            check(simd);
        }
    }
}
