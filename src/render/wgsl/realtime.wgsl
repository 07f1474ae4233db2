// The documents' local model. Twin of realtime.rs, in f32.

// The environment blurred for a width: linear between the levels, whose widths, starts and sides are listed.
fn blurred_look(w: vec3f, alpha: f32) -> vec3f {
    let levels = scene_word(28u);
    let count = scene_word(29u);
    var above = 1u;
    while above + 1u < count && alpha > scene_real(levels + 3u * above) {
        above++;
    }
    let low = levels + 3u * (above - 1u);
    let high = levels + 3u * above;
    let share = (alpha - scene_real(low)) / (scene_real(high) - scene_real(low));
    let a = map_look(scene_word(low + 1u), scene_word(low + 2u), w).radiance;
    let b = map_look(scene_word(high + 1u), scene_word(high + 2u), w).radiance;
    return a + (b - a) * share;
}

const widest: f32 = 0.999;

// The radiance of a fragment; `rest` is its occlusion, distance and footprint.
fn shade_fragment(direction: vec3f, position: vec3f, tangent: vec3f, bitangent: vec3f, normal: vec3f, uv: vec2f,
    uv_per_length: vec2f, rest: vec3f) -> vec3f {
    material_prepare(Point(position, rest.x, tangent, rest.y, bitangent, rest.z, uv, uv_per_length));
    let wo = -vec3f(dot(direction, tangent), dot(direction, bitangent), dot(direction, normal));
    var sum = vec3f(0.0, 0.0, 0.0);
    for (var i = 0u; i < scene_word(21u); i++) {
        let arriving = light_at(i, position);
        let towards = arriving.towards;
        let wi = vec3f(dot(towards, tangent), dot(towards, bitangent), dot(towards, normal));
        sum += material_reflected(wi, wo) * arriving.irradiance;
    }
    for (var i = 0u; i < material_mirrors; i++) {
        let mirror = material_mirrored(i, wo);
        let along = tangent * mirror.direction.x + bitangent * mirror.direction.y + normal * mirror.direction.z;
        let alpha = select(min(mirror.alpha, widest), 1.0, mirror.diffuse);
        sum += mirror.weight * blurred_look(along, alpha);
    }
    return sum;
}
