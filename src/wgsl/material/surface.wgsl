// What a material is told of a point, in the object's own space.
struct Point {
    position: vec3f,
    // How hidden it is, from 0 to 1.
    occlusion: f32,
    // The unit directions along the surface in which u and v grow, and how much they grow for a unit of length.
    tangent: vec3f,
    // How far the viewer is.
    distance: f32,
    bitangent: vec3f,
    // The width of what a pixel covers.
    footprint: f32,
    uv: vec2f,
    uv_per_length: vec2f,
}

// Light from one direction of a blurred environment.
struct Mirror {
    direction: vec3f,
    alpha: f32,
    weight: vec3f,
    // Blurred by a cosine, not by a lobe.
    diffuse: bool,
}

// A direction towards the light and its density, 0 where there is none.
struct Drawn {
    wi: vec3f,
    pdf: f32,
}

fn _shifted(point: Point, along: f32, across: f32) -> Point {
    var moved = point;
    moved.position = point.position + point.tangent * along + point.bitangent * across;
    moved.uv = point.uv + vec2f(along, across) * point.uv_per_length;
    return moved;
}

fn _mirror_of(wo: vec3f) -> vec3f {
    return vec3f(-wo.x, -wo.y, wo.z);
}

// The columns are the tangent, bitangent and normal of a frame whose tangent leans on +x.
fn _frame_about(normal: vec3f) -> mat3x3f {
    let across = vec3f(1.0, 0.0, 0.0) - normal * normal.x;
    let square = dot(across, across);
    let leaning = across * inverseSqrt(select(1.0, square, square > 1e-14));
    let tangent = select(vec3f(0.0, 0.0, -sign(normal.x)), leaning, square > 1e-14);
    return mat3x3f(tangent, cross(normal, tangent), normal);
}

fn _turned(w: vec3f, turn: vec2f) -> vec3f {
    return vec3f(turn.x * w.x + turn.y * w.y, turn.x * w.y - turn.y * w.x, w.z);
}

fn _interface_terms(cos_i: f32, n: vec3f, k: vec3f, n_above: f32, channel: u32) -> brdf::fresnel::Fresnel {
    if k[channel] == 0.0 {
        return brdf::fresnel::dielectric(cos_i, n[channel] / n_above);
    }
    return brdf::fresnel::conductor(cos_i, n[channel] / n_above, k[channel] / n_above);
}

fn _terms_of(cos_i: f32, layer: brdf::layered::Layer, n_above: f32) -> array<vec3f, 2> {
    let r = _interface_terms(cos_i, layer.n, layer.k, n_above, 0u);
    let g = _interface_terms(cos_i, layer.n, layer.k, n_above, 1u);
    let b = _interface_terms(cos_i, layer.n, layer.k, n_above, 2u);
    return array<vec3f, 2>(
        vec3f(r.reflectance, g.reflectance, b.reflectance),
        vec3f(r.transmittance, g.transmittance, b.transmittance));
}

fn _one_way(layer: brdf::layered::Layer, cosine: f32) -> vec3f {
    let half_thickness = 0.5 * layer.thickness;
    return vec3f(
        brdf::absorption::transmittance(layer.sigma.x, half_thickness, cosine, cosine),
        brdf::absorption::transmittance(layer.sigma.y, half_thickness, cosine, cosine),
        brdf::absorption::transmittance(layer.sigma.z, half_thickness, cosine, cosine));
}

// The share of a normal distribution within x of its middle, within .7 %.
fn _inside(x: f32) -> f32 {
    return sqrt(max(1.0 - exp(max(-1.27323954473516268 * x * x, -80.0)), 0.0));
}

// What of a lobe leaves the stack, and how much of it is far from the mirror direction; `critical` is the sine of total reflection.
fn _left(view: vec3f, alpha: f32, critical: f32) -> vec2f {
    let cosine = sqrt((1.0 - critical) * (1.0 + critical));
    let sine = sqrt(dot(view.xy, view.xy));
    let upright = select(1.0, view.z, view.z > 0.0);
    let scale = 1.0 / (alpha * (cosine + upright));
    let near = max(critical - sine, 0.0) * scale + 0.5 * alpha * sine / upright;
    let along = 0.5 * (_inside(near) + _inside((critical + sine) * scale));
    let across = _inside(0.81 * critical * scale);
    let unmasked = 1.0 - 0.27 * alpha * alpha * upright;
    let apart = max(upright - cosine, 1e-6);
    return vec2f(along * across * unmasked, 1.0 - exp(max(-alpha / (14.0 * apart), -80.0)));
}

// The lobe or the cosine of the layer at `at` of those from `first` on; as printed it keeps all of its F.
fn _layer_mirror(first: u32, at: u32, printed: bool, wo: vec3f) -> Mirror {
    var seen = vec3f(1.0, 1.0, 1.0);
    var lit = vec3f(1.0, 1.0, 1.0);
    var view = wo;
    var light = vec3f(0.866025403784438647, 0.0, 0.5);
    var n_above = 1.0;
    var least = 1.0;
    for (var position = 0u; position < at; position++) {
        let layer = spot_layers[first + position];
        let at_view = _terms_of(view.z, layer, n_above);
        let at_light = _terms_of(light.z, layer, n_above);
        let eta = layer.n.x / n_above;
        view = brdf::refraction::refract(view, eta);
        light = brdf::refraction::refract(light, eta);
        if min(view.z, light.z) <= 0.0 {
            return Mirror(_mirror_of(wo), 1.0, vec3f(0.0, 0.0, 0.0), false);
        }
        seen *= at_view[1] * _one_way(layer, view.z);
        lit *= at_light[1] * _one_way(layer, light.z);
        n_above = layer.n.x;
        least = min(least, n_above);
    }
    let layer = spot_layers[first + at];
    if layer.kind == brdf::layered::diffuse_base {
        return Mirror(vec3f(0.0, 0.0, 1.0), 1.0, layer.albedo * seen * lit / (n_above * n_above), true);
    }
    let terms = _terms_of(view.z, layer, n_above);
    let leaves = select(_left(view, layer.alpha, min(least / n_above, 1.0)), vec2f(1.0, 0.0), printed);
    let weight = terms[0] * seen * (seen + (lit - seen) * leaves.y) * leaves.x;
    return Mirror(_mirror_of(wo), min(layer.alpha * n_above, 1.0), weight, false);
}

// The cosine of the documents' diffuse term over the interface at `first`: F at the half vector of the view and the normal.
fn _scattered(first: u32, sigma: vec3f, wo: vec3f) -> Mirror {
    let terms = _terms_of(sqrt(0.5 * (1.0 + wo.z)), spot_layers[first], 1.0);
    return Mirror(vec3f(0.0, 0.0, 1.0), 1.0, (vec3f(1.0) - sigma) * (vec3f(1.0) - terms[0]), true);
}
