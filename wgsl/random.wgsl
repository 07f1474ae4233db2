// Random numbers without state: a hash of (seed, index, dimension). Twin of src/random.rs, to the bit.

// Four numbers in [0, 1), multiples of 2^-24: the numbers of one sample in one group of dimensions.
fn random(seed: u32, index: u32, dimension: u32) -> vec4f {
    return vec4f(_words(vec4u(index, dimension, seed, 0u)) >> vec4u(8u)) * 0x1p-24;
}

// Jarzynski & Olano 2020, pcg4d.
fn _words(words: vec4u) -> vec4u {
    return _round_of(_fold(_round_of(words * 1664525u + 1013904223u)));
}

fn _round_of(words: vec4u) -> vec4u {
    let x = words.x + words.y * words.w;
    let y = words.y + words.z * x;
    let z = words.z + x * y;
    return vec4u(x, y, z, words.w + y * z);
}

fn _fold(words: vec4u) -> vec4u {
    return words ^ (words >> vec4u(16u));
}
