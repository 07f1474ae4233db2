// The path tracer. Twin of offline.rs, in f32, with the same random numbers.

const both_ways: u32 = 0u;
const environment_alone: u32 = 1u;
const material_alone: u32 = 2u;
const roulette_from: u32 = 3u;

struct Tally {
    sum: vec3f,
    squares: vec3f,
}

// The weight of a direction drawn with the first density, that the second draws as well.
fn _heuristic(own: f32, other: f32) -> f32 {
    // Beyond this the weight is below 1e-30.
    let ratio = min(other / own, 1e15);
    return 1.0 / (1.0 + ratio * ratio);
}

// The radiance that one path finds for a pixel.
fn trace(pixel: u32, seed: u32, index: u32) -> vec3f {
    let last = scene_word(17u);
    let strategy = scene_word(18u);
    let convex = shape_is_convex();
    let jitter = brdf::random::random(seed, index, 0u);
    var ray = camera_ray(pixel, jitter.xy);
    var sum = vec3f(0.0, 0.0, 0.0);
    var throughput = vec3f(1.0, 1.0, 1.0);
    var density = 0.0;
    var travelled = 0.0;
    for (var depth = 0u; depth <= last; depth++) {
        var hit = _missed();
        if depth == 0u || !convex {
            hit = shape_hit(ray, far);
        }
        if !hit.found {
            if (depth == 0u && !backdrop()) || !environment_shines() {
                return sum;
            }
            let seen = environment_look(ray.direction);
            var weight = 1.0;
            if depth > 0u && strategy == both_ways {
                weight = _heuristic(density, seen.density);
            }
            if depth > 0u && strategy == environment_alone {
                weight = 0.0;
            }
            return sum + throughput * seen.radiance * weight;
        }
        if depth == last {
            return sum;
        }
        travelled += hit.distance;
        material_prepare(point_of(hit, travelled));
        let wo = to_local(hit, -ray.direction);
        for (var i = 0u; i < scene_word(21u); i++) {
            let arriving = light_at(i, hit.position);
            let wi = to_local(hit, arriving.towards);
            if wi.z > 0.0 && dot(hit.geometric, arriving.towards) > 0.0
                && (convex || !shape_blocks(leaving(hit, arriving.towards), arriving.distance)) {
                sum += throughput * material_reflected(wi, wo) * arriving.irradiance;
            }
        }
        let group = 1u + 3u * depth;
        if strategy != material_alone {
            let shone = environment_sample(brdf::random::random(seed, index, group + 1u));
            let wi = to_local(hit, shone.towards);
            if shone.density > 0.0 && wi.z > 0.0 && dot(hit.geometric, shone.towards) > 0.0
                && (convex || !shape_blocks(leaving(hit, shone.towards), far)) {
                var weight = 1.0;
                if strategy == both_ways {
                    weight = _heuristic(shone.density, material_pdf(wi, wo));
                }
                sum += throughput * material_reflected(wi, wo) * shone.radiance * (weight / shone.density);
            }
        }
        let next = material_sample(wo, brdf::random::random(seed, index, group));
        let towards = to_world(hit, next.wi);
        if next.pdf <= 0.0 || dot(hit.geometric, towards) <= 0.0 {
            return sum;
        }
        throughput *= material_reflected(next.wi, wo) * (1.0 / next.pdf);
        let largest = max(throughput.x, max(throughput.y, throughput.z));
        if largest <= 0.0 {
            return sum;
        }
        if depth >= roulette_from {
            let stays = min(largest, 1.0);
            if brdf::random::random(seed, index, group + 2u).x >= stays {
                return sum;
            }
            throughput /= stays;
        }
        density = next.pdf;
        ray = leaving(hit, towards);
    }
    return sum;
}

// What `count` paths of a pixel from `first` on add up to.
fn trace_pixel(pixel: u32, seed: u32, first: u32, count: u32) -> Tally {
    var tally = Tally(vec3f(0.0, 0.0, 0.0), vec3f(0.0, 0.0, 0.0));
    for (var i = first; i < first + count; i++) {
        let radiance = trace(pixel, seed, i);
        tally.sum += radiance;
        tally.squares += radiance * radiance;
    }
    return tally;
}
