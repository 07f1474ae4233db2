#define_import_path engine::maths

const half = 0.5;

fn half_of(x: f32) -> f32 {
    return half * x;
}
