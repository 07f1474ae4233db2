// Images at the coordinates of a surface. Twin of src/texture/image.rs.
//
// The texels of all images lie one after another, row by row. The embedding shader supplies them:
//
//     fn material_texel(index: u32) -> vec4f

// The four texels around a point blended linearly, the image repeated.
fn bilinear(first: u32, width: u32, height: u32, uv: vec2f) -> vec4f {
    let size = vec2f(f32(width), f32(height));
    let place = clamp(uv - floor(uv), vec2f(0.0), vec2f(1.0)) * size - 0.5;
    let cell = floor(place);
    let share = clamp(place - cell, vec2f(0.0), vec2f(1.0));
    // The place is above -1: a width more keeps the columns positive.
    let sizes = vec2u(width, height);
    let low = vec2u(vec2i(cell) + vec2i(sizes));
    return _blended(first, width, low % sizes, (low + 1u) % sizes, share);
}

// The four texels around a point blended linearly, those at the edges repeated outwards.
fn bilinear_clamped(first: u32, width: u32, height: u32, uv: vec2f) -> vec4f {
    let last = vec2u(width, height) - 1u;
    let place = clamp(uv, vec2f(0.0), vec2f(1.0)) * vec2f(f32(width), f32(height)) - 0.5;
    let inside = clamp(place, vec2f(0.0), vec2f(last));
    let cell = floor(inside);
    let share = clamp(inside - cell, vec2f(0.0), vec2f(1.0));
    let low = vec2u(cell);
    return _blended(first, width, low, min(low + 1u, last), share);
}

// The texel that a point lies in, the image repeated.
fn nearest(first: u32, width: u32, height: u32, uv: vec2f) -> vec4f {
    let place = vec2u(clamp(uv - floor(uv), vec2f(0.0), vec2f(1.0)) * vec2f(f32(width), f32(height)));
    return material_texel(first + (place.y % height) * width + place.x % width);
}

// The texel that a point lies in, those at the edges repeated outwards.
fn nearest_clamped(first: u32, width: u32, height: u32, uv: vec2f) -> vec4f {
    let place = vec2u(clamp(uv, vec2f(0.0), vec2f(1.0)) * vec2f(f32(width), f32(height)));
    return material_texel(first + min(place.y, height - 1u) * width + min(place.x, width - 1u));
}

fn _blended(first: u32, width: u32, low: vec2u, high: vec2u, share: vec2f) -> vec4f {
    let here = first + low.y * width;
    let next = first + high.y * width;
    let above = _between(material_texel(here + low.x), material_texel(here + high.x), share.x);
    let below = _between(material_texel(next + low.x), material_texel(next + high.x), share.x);
    return _between(above, below, share.y);
}

fn _between(a: vec4f, b: vec4f, share: f32) -> vec4f {
    return (1.0 - share) * a + share * b;
}
