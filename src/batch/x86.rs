//! The registers of x86-64: of every such processor, of those with AVX2 and FMA, and of those with AVX-512.
#![allow(unsafe_code)]

use super::lanes::Register;
use crate::real::Real;
use core::arch::x86_64::*;

/// Constants of a register, and the functions whose intrinsics have one signature in every instruction set.
macro_rules! common {
    ($register:ident[$count:literal] $bits:ty; $($method:ident $intrinsic:ident),*; load $load:ident, store $store:ident, splat $splat:ident) => {
        type Bits = $bits;
        const COUNT: usize = $count;
        const CONSTANTS: [Self; 8] = {
            let constants = [0.0, 1.0, 0.5, 2.0, f32::PI, f32::FRAC_1_PI, <f32 as Real>::EPSILON, f32::EXP_LIMIT];
            let mut registers = [[0.0; $count]; 8];
            let mut i = 0;
            while i < 8 {
                registers[i] = [constants[i]; $count];
                i += 1;
            }
            // SAFETY: a register is as many f32.
            unsafe { core::mem::transmute::<[[f32; $count]; 8], [$register; 8]>(registers) }
        };
        #[inline(always)]
        unsafe fn splat(x: f32) -> Self {
            unsafe { $splat(x) }
        }
        #[inline(always)]
        unsafe fn load(from: &[f32]) -> Self {
            debug_assert!(from.len() >= $count);
            unsafe { $load(from.as_ptr()) }
        }
        #[inline(always)]
        unsafe fn store(self, to: &mut [f32]) {
            debug_assert!(to.len() >= $count);
            unsafe { $store(to.as_mut_ptr(), self) }
        }
        $(
            #[inline(always)]
            unsafe fn $method(self, other: Self) -> Self {
                unsafe { $intrinsic(self, other) }
            }
        )*
    };
}

/// The bits of √½: exponents are counted from there, so that fractions are centred on 1.
const ROOT_HALF: i32 = core::f32::consts::FRAC_1_SQRT_2.to_bits() as i32;

impl Register for __m128 {
    common!(__m128[4] __m128; add _mm_add_ps, sub _mm_sub_ps, mul _mm_mul_ps, div _mm_div_ps, min _mm_min_ps, max _mm_max_ps;
        load _mm_loadu_ps, store _mm_storeu_ps, splat _mm_set1_ps);

    #[inline(always)]
    unsafe fn neg(self) -> Self {
        unsafe { _mm_xor_ps(self, _mm_set1_ps(-0.0)) }
    }
    #[inline(always)]
    unsafe fn abs(self) -> Self {
        unsafe { _mm_andnot_ps(_mm_set1_ps(-0.0), self) }
    }
    #[inline(always)]
    unsafe fn sqrt(self) -> Self {
        unsafe { _mm_sqrt_ps(self) }
    }
    #[inline(always)]
    unsafe fn mul_add(self, factor: Self, addend: Self) -> Self {
        unsafe { _mm_add_ps(_mm_mul_ps(self, factor), addend) }
    }
    #[inline(always)]
    unsafe fn product_error(self, other: Self, product: Self) -> Self {
        // Two halves of the product in double precision, where it is exact.
        unsafe {
            let error = |a: Self, b: Self, p: Self| {
                _mm_cvtpd_ps(_mm_sub_pd(_mm_mul_pd(_mm_cvtps_pd(a), _mm_cvtps_pd(b)), _mm_cvtps_pd(p)))
            };
            let high = |x: Self| _mm_movehl_ps(x, x);
            _mm_movelh_ps(error(self, other, product), error(high(self), high(other), high(product)))
        }
    }
    #[inline(always)]
    unsafe fn lt(self, other: Self) -> Self::Bits {
        unsafe { _mm_cmplt_ps(self, other) }
    }
    #[inline(always)]
    unsafe fn le(self, other: Self) -> Self::Bits {
        unsafe { _mm_cmple_ps(self, other) }
    }
    #[inline(always)]
    unsafe fn select(bits: Self::Bits, yes: Self, no: Self) -> Self {
        unsafe { _mm_or_ps(_mm_and_ps(bits, yes), _mm_andnot_ps(bits, no)) }
    }
    #[inline(always)]
    unsafe fn not(bits: Self::Bits) -> Self::Bits {
        unsafe { _mm_xor_ps(bits, _mm_castsi128_ps(_mm_set1_epi32(-1))) }
    }
    #[inline(always)]
    unsafe fn and(a: Self::Bits, b: Self::Bits) -> Self::Bits {
        unsafe { _mm_and_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn or(a: Self::Bits, b: Self::Bits) -> Self::Bits {
        unsafe { _mm_or_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn mask(bits: Self::Bits) -> u32 {
        unsafe { _mm_movemask_ps(bits) as u32 }
    }
    #[inline(always)]
    unsafe fn scale(self, shifted: Self, _: Self) -> Self {
        unsafe {
            let power = _mm_add_epi32(_mm_castps_si128(shifted), _mm_set1_epi32(127));
            _mm_mul_ps(self, _mm_castsi128_ps(_mm_slli_epi32::<23>(power)))
        }
    }
    #[inline(always)]
    unsafe fn split(self) -> (Self, Self) {
        unsafe {
            let bits = _mm_castps_si128(self);
            let power = _mm_srai_epi32::<23>(_mm_sub_epi32(bits, _mm_set1_epi32(ROOT_HALF)));
            let fraction = _mm_sub_epi32(bits, _mm_slli_epi32::<23>(power));
            (_mm_castsi128_ps(fraction), _mm_cvtepi32_ps(power))
        }
    }
}

impl Register for __m256 {
    common!(__m256[8] __m256; add _mm256_add_ps, sub _mm256_sub_ps, mul _mm256_mul_ps, div _mm256_div_ps, min _mm256_min_ps, max _mm256_max_ps;
        load _mm256_loadu_ps, store _mm256_storeu_ps, splat _mm256_set1_ps);

    #[inline(always)]
    unsafe fn neg(self) -> Self {
        unsafe { _mm256_xor_ps(self, _mm256_set1_ps(-0.0)) }
    }
    #[inline(always)]
    unsafe fn abs(self) -> Self {
        unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self) }
    }
    #[inline(always)]
    unsafe fn sqrt(self) -> Self {
        unsafe { _mm256_sqrt_ps(self) }
    }
    #[inline(always)]
    unsafe fn mul_add(self, factor: Self, addend: Self) -> Self {
        unsafe { _mm256_fmadd_ps(self, factor, addend) }
    }
    #[inline(always)]
    unsafe fn product_error(self, other: Self, product: Self) -> Self {
        unsafe { _mm256_fmsub_ps(self, other, product) }
    }
    #[inline(always)]
    unsafe fn lt(self, other: Self) -> Self::Bits {
        unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self, other) }
    }
    #[inline(always)]
    unsafe fn le(self, other: Self) -> Self::Bits {
        unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self, other) }
    }
    #[inline(always)]
    unsafe fn select(bits: Self::Bits, yes: Self, no: Self) -> Self {
        unsafe { _mm256_blendv_ps(no, yes, bits) }
    }
    #[inline(always)]
    unsafe fn not(bits: Self::Bits) -> Self::Bits {
        unsafe { _mm256_xor_ps(bits, _mm256_castsi256_ps(_mm256_set1_epi32(-1))) }
    }
    #[inline(always)]
    unsafe fn and(a: Self::Bits, b: Self::Bits) -> Self::Bits {
        unsafe { _mm256_and_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn or(a: Self::Bits, b: Self::Bits) -> Self::Bits {
        unsafe { _mm256_or_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn mask(bits: Self::Bits) -> u32 {
        unsafe { _mm256_movemask_ps(bits) as u32 }
    }
    #[inline(always)]
    unsafe fn scale(self, shifted: Self, _: Self) -> Self {
        unsafe {
            let power = _mm256_add_epi32(_mm256_castps_si256(shifted), _mm256_set1_epi32(127));
            _mm256_mul_ps(self, _mm256_castsi256_ps(_mm256_slli_epi32::<23>(power)))
        }
    }
    #[inline(always)]
    unsafe fn split(self) -> (Self, Self) {
        unsafe {
            let bits = _mm256_castps_si256(self);
            let power = _mm256_srai_epi32::<23>(_mm256_sub_epi32(bits, _mm256_set1_epi32(ROOT_HALF)));
            let fraction = _mm256_sub_epi32(bits, _mm256_slli_epi32::<23>(power));
            (_mm256_castsi256_ps(fraction), _mm256_cvtepi32_ps(power))
        }
    }
}

impl Register for __m512 {
    common!(__m512[16] __mmask16; add _mm512_add_ps, sub _mm512_sub_ps, mul _mm512_mul_ps, div _mm512_div_ps, min _mm512_min_ps, max _mm512_max_ps;
        load _mm512_loadu_ps, store _mm512_storeu_ps, splat _mm512_set1_ps);

    #[inline(always)]
    unsafe fn neg(self) -> Self {
        unsafe { _mm512_xor_ps(self, _mm512_set1_ps(-0.0)) }
    }
    #[inline(always)]
    unsafe fn abs(self) -> Self {
        unsafe { _mm512_abs_ps(self) }
    }
    #[inline(always)]
    unsafe fn sqrt(self) -> Self {
        unsafe { _mm512_sqrt_ps(self) }
    }
    #[inline(always)]
    unsafe fn mul_add(self, factor: Self, addend: Self) -> Self {
        unsafe { _mm512_fmadd_ps(self, factor, addend) }
    }
    #[inline(always)]
    unsafe fn product_error(self, other: Self, product: Self) -> Self {
        unsafe { _mm512_fmsub_ps(self, other, product) }
    }
    #[inline(always)]
    unsafe fn lt(self, other: Self) -> Self::Bits {
        unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self, other) }
    }
    #[inline(always)]
    unsafe fn le(self, other: Self) -> Self::Bits {
        unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self, other) }
    }
    #[inline(always)]
    unsafe fn select(bits: Self::Bits, yes: Self, no: Self) -> Self {
        unsafe { _mm512_mask_blend_ps(bits, no, yes) }
    }
    #[inline(always)]
    unsafe fn not(bits: Self::Bits) -> Self::Bits {
        !bits
    }
    #[inline(always)]
    unsafe fn and(a: Self::Bits, b: Self::Bits) -> Self::Bits {
        a & b
    }
    #[inline(always)]
    unsafe fn or(a: Self::Bits, b: Self::Bits) -> Self::Bits {
        a | b
    }
    #[inline(always)]
    unsafe fn mask(bits: Self::Bits) -> u32 {
        u32::from(bits)
    }
    #[inline(always)]
    unsafe fn scale(self, _: Self, power: Self) -> Self {
        unsafe { _mm512_scalef_ps(self, power) }
    }
    #[inline(always)]
    unsafe fn split(self) -> (Self, Self) {
        unsafe {
            let bits = _mm512_castps_si512(self);
            let power = _mm512_srai_epi32::<23>(_mm512_sub_epi32(bits, _mm512_set1_epi32(ROOT_HALF)));
            let fraction = _mm512_sub_epi32(bits, _mm512_slli_epi32::<23>(power));
            (_mm512_castsi512_ps(fraction), _mm512_cvtepi32_ps(power))
        }
    }
}
