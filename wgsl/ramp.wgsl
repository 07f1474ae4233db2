// Colour ramps. Twin of src/texture/ramp.rs.
//
// The stops of all ramps lie one after another. The embedding shader supplies them, the colour and in w the position:
//
//     fn ramp_stop(index: u32) -> vec4f

import package::mask;

// (1-t)·a + t·b, each channel by its own t.
fn two(a: vec3f, b: vec3f, t: vec3f) -> vec3f {
    return (1.0 - t) * a + t * b;
}

// Linear between neighbouring stops, constant before the first and after the last; 0 without stops.
fn ramp(first: u32, count: u32, t: f32) -> vec3f {
    if count == 0u {
        return vec3f(0.0);
    }
    var before = ramp_stop(first);
    var colour = before.xyz;
    for (var i = 1u; i < count; i++) {
        let stop = ramp_stop(first + i);
        colour = two(colour, stop.xyz, vec3f(mask::grey(t, before.w, stop.w)));
        before = stop;
    }
    return colour;
}

// Each stop's colour from its position on, the edges soft to either side.
fn bands(first: u32, count: u32, softness: f32, t: f32) -> vec3f {
    if count == 0u {
        return vec3f(0.0);
    }
    var colour = ramp_stop(first).xyz;
    for (var i = 1u; i < count; i++) {
        let stop = ramp_stop(first + i);
        colour = two(colour, stop.xyz, vec3f(mask::soft_threshold(t, stop.w, softness)));
    }
    return colour;
}

// A noise at an age as the grey value of a ramp with this many bands: (age·(count-1) + value)/count.
fn aged(value: f32, age: f32, count: u32) -> f32 {
    let bands = f32(max(count, 1u));
    return (clamp(age, 0.0, 1.0) * (bands - 1.0) + clamp(value, 0.0, 1.0)) / bands;
}
