// The documents' metal flakes (Elek 2010, section 4.1). Twin of src/material/flake.rs.

// The direction of N + max(distance, 1)·z + (2·texel - 1); the zero vector stays zero.
fn flake_normal(normal: vec3f, distance: f32, texel: vec3f) -> vec3f {
    let x = normal.x + (2.0 * texel.x - 1.0);
    let y = normal.y + (2.0 * texel.y - 1.0);
    let z = normal.z + max(distance, 1.0) + (2.0 * texel.z - 1.0);
    // By the largest component first: the square of a large distance does not overflow.
    let largest = max(max(abs(x), abs(y)), abs(z));
    let some = largest > 0.0;
    let scaled = vec3f(x, y, z) / select(1.0, largest, some);
    let square = scaled.x * scaled.x + scaled.y * scaled.y + scaled.z * scaled.z;
    return scaled / sqrt(select(1.0, square, some));
}
