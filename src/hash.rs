//! Integers that look random: pcg4d, of which walks draw their numbers and flakes their orientations.

/// Four hashed words of four words: every bit of the result depends on every bit of the argument.
///
/// Source: Jarzynski & Olano 2020, "Hash Functions for GPU Rendering", `pcg4d` of the supplement's listing.
#[inline]
pub(crate) fn pcg(words: [u32; 4]) -> [u32; 4] {
    let [mut x, mut y, mut z, mut w] = words.map(|v| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let round = |x: &mut u32, y: &mut u32, z: &mut u32, w: &mut u32| {
        *x = x.wrapping_add(y.wrapping_mul(*w));
        *y = y.wrapping_add(z.wrapping_mul(*x));
        *z = z.wrapping_add(x.wrapping_mul(*y));
        *w = w.wrapping_add(y.wrapping_mul(*z));
    };
    round(&mut x, &mut y, &mut z, &mut w);
    for v in [&mut x, &mut y, &mut z, &mut w] {
        *v ^= *v >> 16;
    }
    round(&mut x, &mut y, &mut z, &mut w);
    [x, y, z, w]
}
