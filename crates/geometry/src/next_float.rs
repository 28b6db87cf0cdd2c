//! The next floating-point number on each axis.
//!
//! Read as integers, with the negative ones mirrored, the bits of floating-point numbers have the
//! order of the numbers. On x86-64 the integers of all axes are an SSE2 register, which the
//! compiler does not make of them by itself. Elsewhere they are arrays, with the same results.

use glam::Vec4;

/// Returns the next number in the direction of a step on each axis. A number stays as it is where
/// the step is zero, and one that is not finite. There is no branch, because the signs of steps are
/// unpredictable.
#[inline]
pub(crate) fn next_float(p: Vec4, step: Vec4) -> Vec4 {
    #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
    return sse2(p, step);
    #[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
    portable(p, step)
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[inline(always)]
fn sse2(p: Vec4, step: Vec4) -> Vec4 {
    #![expect(unsafe_code, reason = "intrinsics need a processor feature")]
    use core::arch::x86_64::*;
    // SAFETY: the intrinsics need SSE2, and this function is compiled only with it.
    let next = unsafe {
        let mirrored = |bits| _mm_xor_si128(bits, _mm_srli_epi32::<1>(_mm_srai_epi32::<31>(bits)));
        let place = mirrored(_mm_castps_si128(p.into()));
        // A comparison is -1 where it is true.
        let up = _mm_castps_si128(_mm_cmpgt_ps(step.into(), _mm_setzero_ps()));
        let down = _mm_castps_si128(_mm_cmplt_ps(step.into(), _mm_setzero_ps()));
        _mm_castsi128_ps(mirrored(_mm_add_epi32(_mm_sub_epi32(place, up), down)))
    };
    Vec4::select(p.is_finite_mask(), next.into(), p)
}

#[cfg(any(test, not(all(target_arch = "x86_64", target_feature = "sse2"))))]
fn portable(p: Vec4, step: Vec4) -> Vec4 {
    let mirrored = |bits: i32| bits ^ ((bits >> 31) & i32::MAX);
    let next = |p: f32, step: f32| {
        let place = mirrored(p.to_bits() as i32);
        let next = place + i32::from(step > 0.0) - i32::from(step < 0.0);
        if p.is_finite() { f32::from_bits(mirrored(next) as u32) } else { p }
    };
    let (p, step) = (p.to_array(), step.to_array());
    Vec4::from_array(core::array::from_fn(|axis| next(p[axis], step[axis])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_number_is_that_of_the_standard_library() {
        let tiny = f32::from_bits(1);
        let numbers = [1.0, -1.0, 2.0, 1e-40, -tiny, 0.1, -3e38, f32::MIN_POSITIVE];
        for p in numbers {
            let steps = Vec4::new(1e-9, -1e-9, 0.0, f32::NAN);
            let expected = [p.next_up(), p.next_down(), p, p];
            assert_eq!(next_float(Vec4::splat(p), steps).to_array(), expected, "{p}");
        }
    }

    #[test]
    fn sse2_and_arrays_give_the_same_bits() {
        let numbers = [0.0, -0.0, 1.0, -2.5, 1e-40, f32::MAX, f32::MIN, f32::INFINITY, f32::NAN];
        for p in numbers {
            for step in numbers.map(|step| [step, -step]).concat() {
                let [p, step] = [p, step].map(Vec4::splat);
                let [found, expected] = [next_float(p, step), portable(p, step)];
                let bits = |v: Vec4| v.to_array().map(f32::to_bits);
                assert_eq!(bits(found), bits(expected), "{p} {step}");
            }
        }
    }
}
