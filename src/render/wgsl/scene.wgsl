// The scene of a picture as words, and what is read of it: camera, lights, environment. Twins of camera.rs, light.rs, octahedral.rs,
// environment.rs and prefilter.rs, in f32. src/render/gpu/words.rs lays the words out.
//
// The embedder supplies
//
//     fn scene_word(index: u32) -> u32

const far: f32 = 3e38;

fn scene_real(index: u32) -> f32 {
    return bitcast<f32>(scene_word(index));
}

fn scene_vector(index: u32) -> vec3f {
    return vec3f(scene_real(index), scene_real(index + 1u), scene_real(index + 2u));
}

struct Ray {
    origin: vec3f,
    direction: vec3f,
}

// The ray through a point of a pixel.
fn camera_ray(pixel: u32, within: vec2f) -> Ray {
    let size = vec2u(scene_word(1u), scene_word(2u));
    let place = (vec2f(vec2u(pixel % size.x, pixel / size.x)) + within) * (2.0 / vec2f(size)) - 1.0;
    let direction = scene_vector(7u) + scene_vector(10u) * place.x - scene_vector(13u) * place.y;
    return Ray(scene_vector(4u), direction / sqrt(dot(direction, direction)));
}

// What arrives at a point from a light.
struct Arriving {
    towards: vec3f,
    distance: f32,
    irradiance: vec3f,
}

fn light_at(index: u32, point: vec3f) -> Arriving {
    let start = scene_word(22u) + 7u * index;
    let kind = scene_word(start);
    let place = scene_vector(start + 1u);
    let power = scene_vector(start + 4u);
    if kind == 0u {
        return Arriving(place, far, power);
    }
    let way = place - point;
    let squared = max(dot(way, way), 1e-14);
    let distance = sqrt(squared);
    return Arriving(way / distance, distance, power / select(squared, distance, kind == 2u));
}

// The point of [-1, 1]² that a direction falls on.
fn octahedral_square(w: vec3f) -> vec2f {
    let point = w.xy / (abs(w.x) + abs(w.y) + abs(w.z));
    let signs = select(vec2f(1.0, 1.0), vec2f(-1.0, -1.0), point < vec2f(0.0, 0.0));
    return select(point, (1.0 - abs(point.yx)) * signs, w.z < 0.0);
}

fn octahedral_direction(point: vec2f) -> vec3f {
    let z = 1.0 - abs(point.x) - abs(point.y);
    let over = max(-z, 0.0);
    let pulled = point - select(vec2f(over, over), vec2f(-over, -over), point < vec2f(0.0, 0.0));
    let w = vec3f(pulled, z);
    return w / sqrt(dot(w, w));
}

struct Seen {
    radiance: vec3f,
    density: f32,
}

fn _texel(start: u32, stride: u32, column: u32, row: u32) -> vec3f {
    return scene_vector(start + 4u * (row * stride + column));
}

// A map at a direction, bilinear, and the fourth number of the texel there.
fn map_look(start: u32, side: u32, w: vec3f) -> Seen {
    let size = f32(side);
    let place = clamp((octahedral_square(w) + 1.0) * 0.5 * size, vec2f(0.0, 0.0), vec2f(size, size));
    let corner = vec2u(place + 0.5);
    let share = place + 0.5 - vec2f(corner);
    let stride = side + 2u;
    let a = _texel(start, stride, corner.x, corner.y);
    let b = _texel(start, stride, corner.x + 1u, corner.y);
    let c = _texel(start, stride, corner.x, corner.y + 1u);
    let d = _texel(start, stride, corner.x + 1u, corner.y + 1u);
    let top = a + (b - a) * share.x;
    let bottom = c + (d - c) * share.x;
    let inside = corner + select(vec2u(0u, 0u), vec2u(1u, 1u), share >= vec2f(0.5, 0.5));
    return Seen(top + (bottom - top) * share.y, scene_real(start + 4u * (inside.y * stride + inside.x) + 3u));
}

fn environment_shines() -> bool {
    return (scene_word(3u) & 2u) != 0u;
}

fn backdrop() -> bool {
    return (scene_word(3u) & 1u) != 0u;
}

// The radiance from a direction, and the density with which environment_sample draws it.
fn environment_look(w: vec3f) -> Seen {
    let seen = map_look(scene_word(23u), scene_word(24u), w);
    let inverse = 1.0 / (abs(w.x) + abs(w.y) + abs(w.z));
    return Seen(seen.radiance, seen.density * (inverse * inverse * inverse));
}

struct Shone {
    towards: vec3f,
    density: f32,
    radiance: vec3f,
}

// A direction drawn from the environment; density 0 where there is none.
fn environment_sample(u: vec4f) -> Shone {
    if !environment_shines() {
        return Shone(vec3f(0.0, 0.0, 1.0), 0.0, vec3f(0.0, 0.0, 0.0));
    }
    let side = min(scene_word(24u), 128u);
    let count = side * side;
    // Sides are powers of two: the product is exact.
    let place = min(u32(u.x * f32(count)), count - 1u);
    let entry = scene_word(25u) + 2u * place;
    let chosen = select(scene_word(entry + 1u), place, u.y < scene_real(entry));
    let corner = vec2f(f32(chosen % side), f32(chosen / side));
    let towards = octahedral_direction((corner + u.zw) * (2.0 / f32(side)) - 1.0);
    let seen = environment_look(towards);
    return Shone(towards, seen.density, seen.radiance);
}
