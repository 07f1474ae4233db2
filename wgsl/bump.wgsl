// Normals from heights and texels, and the frame about them. Twin of src/texture/bump.rs.

// An orthonormal basis within the surface's frame.
struct Frame {
    tangent: vec3f,
    bitangent: vec3f,
    normal: vec3f,
}

// (-dx, -dy, 1), made unit.
fn normal_from_slopes(dx: f32, dy: f32) -> vec3f {
    return _unit(vec3f(-dx, -dy, 1.0));
}

// The differences to a step along the tangent and to one along the bitangent, over the step; 0 at step 0.
fn slopes(here: f32, along: f32, across: f32, step: f32) -> vec2f {
    let none = !(step < 0.0 || step > 0.0);
    let difference = (vec2f(along, across) - here) / select(step, 1.0, none);
    return select(difference, vec2f(0.0), none);
}

// A unit normal tilted by the slope of a height in space.
fn tilted(normal: vec3f, slope: vec3f) -> vec3f {
    let along = slope - normal * (slope.x * normal.x + slope.y * normal.y + slope.z * normal.z);
    return _unit(normal - along);
}

// 2c - 1, made unit; a negative z counts as 0.
fn decode_rgb(texel: vec3f) -> vec3f {
    let n = 2.0 * (texel - 0.5);
    return _unit_or_up(vec3f(n.xy, max(n.z, 0.0)));
}

// x from alpha, y from green, z from the unit length (Mihaylov 2013, eq. 4.13); on the horizon out of the disc.
fn decode_two_channel(a: f32, g: f32) -> vec3f {
    let x = 2.0 * (a - 0.5);
    let y = 2.0 * (g - 0.5);
    let squared = x * x + y * y;
    let scale = 1.0 / sqrt(max(squared, 1.0));
    return vec3f(x * scale, y * scale, sqrt(max(1.0 - squared, 0.0)));
}

// (n + 1)/2.
fn encode(normal: vec3f) -> vec3f {
    return (normal + 1.0) * 0.5;
}

// The slopes times strength.
fn scaled(normal: vec3f, strength: f32) -> vec3f {
    return _unit_or_up(vec3f(normal.x * strength, normal.y * strength, normal.z));
}

// The slopes of both added.
fn combined(a: vec3f, b: vec3f) -> vec3f {
    return _unit_or_up(vec3f(a.x * b.z + b.x * a.z, a.y * b.z + b.y * a.z, a.z * b.z));
}

// The frame about a unit normal whose tangent stays +x, made perpendicular to it.
fn frame_about(normal: vec3f) -> Frame {
    let squared = normal.y * normal.y + normal.z * normal.z;
    let across = squared > 0.0;
    let r = sqrt(select(1.0, squared, across));
    let s = select(0.0, normal.y / r, across);
    let c = select(1.0, normal.z / r, across);
    return Frame(vec3f(select(0.0, r, across), -normal.x * s, -normal.x * c), vec3f(0.0, c, -s), normal);
}

fn _unit(v: vec3f) -> vec3f {
    let squared = v.x * v.x + v.y * v.y + v.z * v.z;
    return v * (1.0 / sqrt(select(1.0, squared, squared > 0.0)));
}

fn _unit_or_up(v: vec3f) -> vec3f {
    let is_flat = v.x * v.x + v.y * v.y + v.z * v.z <= 0.0;
    return _unit(vec3f(v.xy, select(v.z, 1.0, is_flat)));
}
