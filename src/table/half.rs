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
        let (size, sign) = (u32::from(self.0 & 0x7fff), u64::from(self.0 & 0x8000) << 48);
        if size >= 0x7c00 {
            let open = if size == 0x7c00 { f64::INFINITY } else { f64::NAN };
            return f64::from_bits(open.to_bits() | sign);
        }
        // The fraction, with the 1 before it of all but subnormals, in units of 2^(exponent − 25). No choice that depends on the
        // number: those of a lobe are of all sizes.
        let exponent = size >> 10;
        let units = (size & 1023) | (u32::from(exponent > 0) << 10);
        let value = f64::from(units) * f64::from_bits(u64::from(exponent.max(1) + 998) << 52);
        f64::from_bits(value.to_bits() | sign)
    }
}
