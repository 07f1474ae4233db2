//! Half-precision numbers, as textures store them.

/// A number of 16 bits: IEEE 754's binary16, the texel of a WebGPU texture `r16float`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(transparent)]
pub struct Half(pub u16);

impl Half {
    /// The largest finite number, 65504.
    pub const MAX: Half = Half(0x7bff);

    /// The nearest number, of two the even one; ±∞ from 65520 on. NaN stays NaN.
    pub fn from_f64(x: f64) -> Self {
        let sign = ((x.to_bits() >> 48) & 0x8000) as u16;
        let size = x.abs();
        if size.is_nan() {
            return Half(sign | 0x7e00);
        }
        if size >= 65_520.0 {
            return Half(sign | 0x7c00);
        }
        // The binary exponent; −14 for all subnormals, which share one spacing.
        let exponent = ((size.to_bits() >> 52) as i64 - 1023).max(-14);
        // The size in units of the spacing, 2^(exponent − 10): below 2¹¹, which adding 2⁵² rounds to a whole number.
        let units = size * f64::from_bits(((1033 - exponent) as u64) << 52);
        let whole = (units + 4_503_599_627_370_496.0) - 4_503_599_627_370_496.0;
        // A carry into the next exponent is the right one.
        Half(sign | ((exponent + 14) as u16 * 1024 + whole as u16))
    }

    /// This number, exactly.
    #[inline(always)]
    pub fn to_f64(self) -> f64 {
        let size = u32::from(self.0 & 0x7fff);
        // The exponent moves from a bias of 15 to one of 127; ∞ and NaN go to the largest.
        let bias = if size >= 0x7c00 { 224 } else { 112 };
        let normal = f32::from_bits((size << 13) + (bias << 23));
        let subnormal = size as f32 * (1.0 / 16_777_216.0);
        let value = if size < 1024 { subnormal } else { normal };
        f64::from(if self.0 >= 0x8000 { -value } else { value })
    }
}
