// Where a ray meets the scene's shape. Twin of shape.rs, torus.rs, mesh.rs and bvh.rs, in f32.

const clearance: f32 = 1e-4;

struct Hit {
    position: vec3f,
    distance: f32,
    geometric: vec3f,
    occlusion: f32,
    tangent: vec3f,
    bitangent: vec3f,
    normal: vec3f,
    uv: vec2f,
    uv_per_length: vec2f,
    found: bool,
}

const _below_one: f32 = 0x1.fffffep-1;
const _inverse_pi: f32 = 0.318309886183790672;

fn _missed() -> Hit {
    let none = vec3f(0.0, 0.0, 0.0);
    return Hit(none, far, none, 0.0, none, none, none, vec2f(0.0, 0.0), vec2f(0.0, 0.0), false);
}

// The angle of the point (x, y) in turns.
fn _turn(x: f32, y: f32) -> f32 {
    let first = brdf::real::angle(abs(y), abs(x)) * _inverse_pi * 0.5;
    let half = select(first, 0.5 - first, x < 0.0);
    let whole = select(half, 1.0 - half, y < 0.0);
    return select(0.0, whole, whole < 1.0 && whole >= 0.0);
}

// The hit with a frame about the normal, whose tangent leans on `along`.
fn _framed(hit: Hit, normal: vec3f, along: vec3f) -> Hit {
    var framed = hit;
    let across = along - normal * dot(normal, along);
    let squared = dot(across, across);
    framed.normal = normal;
    if squared > dot(along, along) * 1.42e-14 {
        framed.tangent = across / sqrt(squared);
    } else {
        // Duff et al. 2017, listing 3.
        let sign = select(1.0, -1.0, normal.z < 0.0);
        let a = -1.0 / (sign + normal.z);
        framed.tangent = vec3f(1.0 + sign * normal.x * normal.x * a, sign * (normal.x * normal.y * a), -sign * normal.x);
    }
    framed.bitangent = cross(normal, framed.tangent);
    return framed;
}

fn to_local(hit: Hit, w: vec3f) -> vec3f {
    return vec3f(dot(w, hit.tangent), dot(w, hit.bitangent), dot(w, hit.normal));
}

fn to_world(hit: Hit, w: vec3f) -> vec3f {
    return hit.tangent * w.x + hit.bitangent * w.y + hit.normal * w.z;
}

fn leaving(hit: Hit, direction: vec3f) -> Ray {
    return Ray(hit.position + hit.geometric * clearance, direction);
}

// Both normals on the side of the ray.
fn _facing(met: Hit, ray: Ray) -> Hit {
    var hit = met;
    if dot(hit.geometric, ray.direction) > 0.0 {
        hit.geometric = -hit.geometric;
    }
    var normal = hit.normal;
    if dot(normal, hit.geometric) < 0.0 {
        normal = -normal;
    }
    if dot(normal, ray.direction) >= 0.0 {
        normal = hit.geometric;
    }
    if any(normal != hit.normal) {
        let before = hit.bitangent;
        hit = _framed(hit, normal, hit.tangent);
        if dot(hit.bitangent, before) < 0.0 {
            hit.uv_per_length.y = -hit.uv_per_length.y;
        }
    }
    return hit;
}

fn _around_per_length(radius: f32) -> f32 {
    return select(0.0, 0.5 * _inverse_pi / select(1.0, radius, radius > 0.0), radius > 0.0);
}

fn _sphere(ray: Ray, within: f32) -> Hit {
    let along = -dot(ray.origin, ray.direction);
    let nearest = ray.origin + ray.direction * along;
    let square = 1.0 - dot(nearest, nearest);
    if square < 0.0 {
        return _missed();
    }
    let distance = along - sqrt(square);
    if distance <= 0.0 || distance >= within {
        return _missed();
    }
    let at = ray.origin + ray.direction * distance;
    let normal = at / sqrt(dot(at, at));
    let radius = sqrt(normal.x * normal.x + normal.y * normal.y);
    let height = brdf::real::angle(radius, abs(normal.z)) * _inverse_pi;
    var hit = _missed();
    hit.found = true;
    hit.distance = distance;
    hit.position = normal;
    hit.geometric = normal;
    hit.uv = vec2f(_turn(normal.x, normal.y), min(select(1.0 - height, height, normal.z < 0.0), _below_one));
    hit.uv_per_length = vec2f(_around_per_length(radius), _inverse_pi);
    return _framed(hit, normal, vec3f(-normal.y, normal.x, 0.0));
}

fn _plane(ray: Ray, within: f32) -> Hit {
    if ray.direction.z == 0.0 {
        return _missed();
    }
    let distance = -ray.origin.z / ray.direction.z;
    let at = ray.origin + ray.direction * distance;
    if distance <= 0.0 || distance >= within || max(abs(at.x), abs(at.y)) > 1.0 {
        return _missed();
    }
    let up = select(-1.0, 1.0, ray.direction.z < 0.0);
    var hit = _missed();
    hit.found = true;
    hit.distance = distance;
    hit.position = vec3f(at.xy, 0.0);
    hit.geometric = vec3f(0.0, 0.0, up);
    hit.normal = hit.geometric;
    hit.tangent = vec3f(1.0, 0.0, 0.0);
    hit.bitangent = vec3f(0.0, up, 0.0);
    hit.uv = clamp((at.xy + 1.0) * 0.5, vec2f(0.0, 0.0), vec2f(_below_one, _below_one));
    hit.uv_per_length = vec2f(0.5, 0.5 * up);
    return hit;
}

const _tolerance: f32 = 4e-6;
const _steps: u32 = 256u;

fn _torus_distance(at: vec3f) -> f32 {
    let across = sqrt(at.x * at.x + at.y * at.y) - 1.0;
    return sqrt(across * across + at.z * at.z) - scene_real(19u);
}

// How far along a ray the torus begins; -1 where it does not.
fn _torus_meets(ray: Ray, within: f32) -> f32 {
    let minor = scene_real(19u);
    let outer = 1.0 + minor;
    let middle = -dot(ray.origin, ray.direction);
    let nearest = ray.origin + ray.direction * middle;
    let square = outer * outer - dot(nearest, nearest);
    if square < 0.0 {
        return -1.0;
    }
    let half = sqrt(square);
    var start = max(middle - half, 0.0);
    var end = min(middle + half, within);
    if abs(ray.direction.z) > 0x1p-23 {
        let inverse = 1.0 / ray.direction.z;
        let a = (-minor - ray.origin.z) * inverse;
        let b = (minor - ray.origin.z) * inverse;
        start = max(start, min(a, b));
        end = min(end, max(a, b));
    } else if abs(ray.origin.z) > minor {
        return -1.0;
    }
    var distance = start;
    for (var i = 0u; i < _steps; i++) {
        if distance >= end + _tolerance {
            return -1.0;
        }
        let step = _torus_distance(ray.origin + ray.direction * distance);
        if step < _tolerance {
            return distance;
        }
        distance += step;
    }
    return -1.0;
}

fn _torus(ray: Ray, within: f32) -> Hit {
    let distance = _torus_meets(ray, within);
    if distance < 0.0 {
        return _missed();
    }
    let at = ray.origin + ray.direction * distance;
    let radius = sqrt(at.x * at.x + at.y * at.y);
    let outwards = vec3f(at.xy / radius, 0.0);
    let across = radius - 1.0;
    let lean = outwards * across + vec3f(0.0, 0.0, at.z);
    let normal = lean / sqrt(dot(lean, lean));
    let v = _turn(across, at.z);
    let place = 2.0 * select(v, 1.0 - v, v > 0.5) * 32.0;
    let node = min(u32(place), 31u);
    let low = scene_real(scene_word(20u) + node);
    let high = scene_real(scene_word(20u) + node + 1u);
    var hit = _missed();
    hit.found = true;
    hit.distance = distance;
    hit.position = outwards + normal * scene_real(19u);
    hit.geometric = normal;
    hit.occlusion = low + (high - low) * (place - f32(node));
    hit.uv = vec2f(_turn(outwards.x, outwards.y), v);
    let ring = sqrt(hit.position.x * hit.position.x + hit.position.y * hit.position.y);
    hit.uv_per_length = vec2f(_around_per_length(ring), 0.5 * _inverse_pi / scene_real(19u));
    return _framed(hit, normal, vec3f(-outwards.y, outwards.x, 0.0));
}

// What a ray met of a mesh: the triangle, its distance and barycentric coordinates.
struct Met {
    distance: f32,
    b: f32,
    c: f32,
    triangle: u32,
    found: bool,
}

// 9 words a vertex: position, normal, uv, occlusion.
fn _vertex(triangle: u32, corner: u32) -> u32 {
    return scene_word(27u) + 9u * (3u * triangle + corner);
}

fn _triangle_meets(triangle: u32, ray: Ray, within: f32) -> Met {
    let a = scene_vector(_vertex(triangle, 0u));
    let edge_b = scene_vector(_vertex(triangle, 1u)) - a;
    let edge_c = scene_vector(_vertex(triangle, 2u)) - a;
    let p = cross(ray.direction, edge_c);
    let determinant = dot(edge_b, p);
    let inverse = 1.0 / select(1.0, determinant, determinant != 0.0);
    let origin = ray.origin - a;
    let u = dot(origin, p) * inverse;
    let q = cross(origin, edge_b);
    let v = dot(ray.direction, q) * inverse;
    let distance = dot(edge_c, q) * inverse;
    let inside = determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0 && distance < within;
    return Met(distance, u, v, triangle, inside);
}

// Where a box begins on a ray; -1 where the ray passes it by.
fn _enters(node: u32, ray: Ray, inverse: vec3f, within: f32) -> f32 {
    let start = scene_word(26u) + 8u * node;
    let a = (scene_vector(start) - ray.origin) * inverse;
    let b = (scene_vector(start + 4u) - ray.origin) * inverse;
    let nearer = min(a, b);
    let farther = max(a, b) * (1.0 + 0x1p-21);
    let near = max(max(nearer.x, nearer.y), max(nearer.z, 0.0));
    return select(-1.0, near, near <= min(min(farther.x, farther.y), min(farther.z, within)));
}

// The nearest triangle, or with `any_will_do` the first that is found.
fn _mesh_meets(ray: Ray, limit: f32, any_will_do: bool) -> Met {
    var best = Met(limit, 0.0, 0.0, 0u, false);
    let steep = abs(ray.direction) > vec3f(1e-20, 1e-20, 1e-20);
    let inverse = 1.0 / select(vec3f(1e-20, 1e-20, 1e-20), ray.direction, steep);
    if _enters(0u, ray, inverse, best.distance) < 0.0 {
        return best;
    }
    var waiting: array<u32, 32>;
    var top = 0u;
    var node = 0u;
    loop {
        let start = scene_word(26u) + 8u * node;
        let first = scene_word(start + 3u);
        let count = scene_word(start + 7u);
        var next = 0u;
        if count > 0u {
            for (var i = first; i < first + count; i++) {
                let met = _triangle_meets(i, ray, best.distance);
                if met.found {
                    best = met;
                    if any_will_do {
                        return best;
                    }
                }
            }
        } else {
            let near = _enters(node + 1u, ray, inverse, best.distance);
            let other = _enters(first, ray, inverse, best.distance);
            if near >= 0.0 && other >= 0.0 {
                let swapped = other < near;
                next = select(node + 1u, first, swapped);
                if top < 32u {
                    waiting[top] = select(first, node + 1u, swapped);
                    top++;
                }
            } else if near >= 0.0 {
                next = node + 1u;
            } else if other >= 0.0 {
                next = first;
            }
        }
        // The root is no child.
        while next == 0u && top > 0u {
            top--;
            if _enters(waiting[top], ray, inverse, best.distance) >= 0.0 {
                next = waiting[top];
            }
        }
        if next == 0u {
            break;
        }
        node = next;
    }
    return best;
}

fn _mesh(ray: Ray, within: f32) -> Hit {
    let met = _mesh_meets(ray, within, false);
    if !met.found {
        return _missed();
    }
    let at = vec3u(_vertex(met.triangle, 0u), _vertex(met.triangle, 1u), _vertex(met.triangle, 2u));
    let a = 1.0 - met.b - met.c;
    let corner_a = scene_vector(at.x);
    let corner_b = scene_vector(at.y);
    let corner_c = scene_vector(at.z);
    let edge_b = corner_b - corner_a;
    let edge_c = corner_c - corner_a;
    let across = cross(edge_b, edge_c);
    let squared = dot(across, across);
    var hit = _missed();
    hit.found = true;
    hit.distance = met.distance;
    hit.position = corner_a * a + corner_b * met.b + corner_c * met.c;
    hit.geometric = across / sqrt(squared);
    if dot(hit.geometric, ray.direction) > 0.0 {
        hit.geometric = -hit.geometric;
    }
    let mixed = scene_vector(at.x + 3u) * a + scene_vector(at.y + 3u) * met.b + scene_vector(at.z + 3u) * met.c;
    let length = sqrt(dot(mixed, mixed));
    let normal = select(hit.geometric, mixed / select(1.0, length, length > 0.0), length > 0.0);
    let uv_a = vec2f(scene_real(at.x + 6u), scene_real(at.x + 7u));
    let uv_b = vec2f(scene_real(at.y + 6u), scene_real(at.y + 7u));
    let uv_c = vec2f(scene_real(at.z + 6u), scene_real(at.z + 7u));
    let grow_b = uv_b - uv_a;
    let grow_c = uv_c - uv_a;
    let determinant = grow_b.x * grow_c.y - grow_c.x * grow_b.y;
    let tangent = (edge_b * grow_c.y - edge_c * grow_b.y) * select(1.0, -1.0, determinant < 0.0);
    hit = _framed(hit, normal, tangent);
    let slope_b = cross(edge_c, across) / squared;
    let slope_c = cross(across, edge_b) / squared;
    hit.uv_per_length = vec2f(
        dot(slope_b * grow_b.x + slope_c * grow_c.x, hit.tangent),
        dot(slope_b * grow_b.y + slope_c * grow_c.y, hit.bitangent));
    let uv = uv_a * a + uv_b * met.b + uv_c * met.c;
    hit.uv = clamp(uv - floor(uv), vec2f(0.0, 0.0), vec2f(_below_one, _below_one));
    hit.occlusion = scene_real(at.x + 8u) * a + scene_real(at.y + 8u) * met.b + scene_real(at.z + 8u) * met.c;
    return hit;
}

// The nearest point of the shape on a ray, within a distance.
fn shape_hit(ray: Ray, within: f32) -> Hit {
    switch scene_word(0u) {
        case 0u: {
            return _sphere(ray, within);
        }
        case 1u: {
            return _facing(_torus(ray, within), ray);
        }
        case 2u: {
            return _plane(ray, within);
        }
        default: {
            return _facing(_mesh(ray, within), ray);
        }
    }
}

// Whether anything of the shape is on a ray that leaves it.
fn shape_blocks(ray: Ray, within: f32) -> bool {
    switch scene_word(0u) {
        case 1u: {
            return _torus_meets(ray, within) >= 0.0;
        }
        case 3u: {
            return _mesh_meets(ray, within, true).found;
        }
        default: {
            return false;
        }
    }
}

fn shape_is_convex() -> bool {
    return scene_word(0u) == 0u || scene_word(0u) == 2u;
}

fn point_of(hit: Hit, travelled: f32) -> Point {
    return Point(hit.position, hit.occlusion, hit.tangent, travelled, hit.bitangent, travelled * scene_real(16u), hit.uv,
        hit.uv_per_length);
}
