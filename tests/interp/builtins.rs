//! Every builtin function and operator: values of the WGSL specification, on the CPU and on every adapter.

use crate::adapters::adapters_for_tests;
use brdf::gpu::Kernel;
use brdf::interval::WgslInterval;
use brdf::shader::interp::{Buffers, Cell, Program, Shader};
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, LN_2, PI};

/// An expression of x, y, z, its arguments, and its value.
type Real = (&'static str, [f32; 3], f64);
/// An expression of the signed i, j and the unsigned u, v, its arguments, and the bits of its value.
type Whole = (&'static str, [u32; 4], u32);

const MINUS_ONE: u32 = u32::MAX;
const LEAST: u32 = 0x8000_0000;

const REALS: &[Real] = &[
    ("x + y * z", [1.0, 2.0, 3.0], 7.0),
    ("x % y", [7.5, 2.0, 0.0], 1.5),
    ("x % y", [-7.5, 2.0, 0.0], -1.5),
    ("-x / y", [1.0, 4.0, 0.0], -0.25),
    ("abs(x)", [-3.5, 0.0, 0.0], 3.5),
    ("acos(x)", [0.5, 0.0, 0.0], PI / 3.0),
    ("acosh(x)", [2.0, 0.0, 0.0], 1.316_957_896_924_816_7),
    ("asin(x)", [0.5, 0.0, 0.0], PI / 6.0),
    ("asinh(x)", [1.0, 0.0, 0.0], 0.881_373_587_019_543),
    ("atan(x)", [1.0, 0.0, 0.0], FRAC_PI_4),
    ("atanh(x)", [0.5, 0.0, 0.0], 0.549_306_144_334_054_9),
    ("atan2(y, x)", [1.0, 1.0, 0.0], FRAC_PI_4),
    ("atan2(y, x)", [-1.0, 1.0, 0.0], 3.0 * FRAC_PI_4),
    ("atan2(y, x)", [-1.0, -1.0, 0.0], -3.0 * FRAC_PI_4),
    ("ceil(x)", [1.25, 0.0, 0.0], 2.0),
    ("ceil(x)", [-1.25, 0.0, 0.0], -1.0),
    ("clamp(x, y, z)", [5.0, 1.0, 2.0], 2.0),
    ("clamp(x, y, z)", [-5.0, 1.0, 2.0], 1.0),
    ("cos(x)", [1.0, 0.0, 0.0], 0.540_302_305_868_139_8),
    ("cosh(x)", [1.0, 0.0, 0.0], 1.543_080_634_815_243_7),
    ("cross(vec3f(x, y, z), vec3f(y, z, x)).x", [1.0, 2.0, 4.0], -14.0),
    ("cross(vec3f(x, y, z), vec3f(y, z, x)).y", [1.0, 2.0, 4.0], 7.0),
    ("cross(vec3f(x, y, z), vec3f(y, z, x)).z", [1.0, 2.0, 4.0], 0.0),
    ("degrees(x)", [1.0, 0.0, 0.0], 180.0 / PI),
    ("determinant(mat2x2f(x, y, z, x))", [3.0, 2.0, 5.0], -1.0),
    ("determinant(mat3x3f(x, y, z, z, x, y, y, z, x))", [3.0, 2.0, 5.0], 70.0),
    ("determinant(mat4x4f(x, y, z, 1.0, 0.0, x, y, z, z, 0.0, x, y, y, z, 0.0, x))", [1.0, 2.0, 3.0], 76.0),
    ("distance(vec2f(x, y), vec2f(y, z))", [1.0, 4.0, 8.0], 5.0),
    ("dot(vec3f(x, y, z), vec3f(y, z, x))", [1.0, 2.0, 4.0], 14.0),
    ("exp(x)", [1.0, 0.0, 0.0], core::f64::consts::E),
    ("exp2(x)", [3.0, 0.0, 0.0], 8.0),
    ("faceForward(vec2f(x, y), vec2f(z, 0.0), vec2f(1.0, 0.0)).x", [1.0, 2.0, 3.0], -1.0),
    ("faceForward(vec2f(x, y), vec2f(z, 0.0), vec2f(1.0, 0.0)).y", [1.0, 2.0, -3.0], 2.0),
    ("floor(x)", [-1.25, 0.0, 0.0], -2.0),
    ("fma(x, y, z)", [2.0, 3.0, 4.0], 10.0),
    ("fract(x)", [-1.25, 0.0, 0.0], 0.75),
    ("frexp(x).fract", [-12.0, 0.0, 0.0], -0.75),
    ("f32(frexp(x).exp)", [-12.0, 0.0, 0.0], 4.0),
    ("f32(frexp(x).exp)", [0.0, 0.0, 0.0], 0.0),
    ("frexp(vec2f(x, y)).fract.y", [1.0, 0.3, 0.0], 0.6),
    ("inverseSqrt(x)", [4.0, 0.0, 0.0], 0.5),
    ("ldexp(x, i32(y))", [1.5, 4.0, 0.0], 24.0),
    ("ldexp(x, i32(y))", [1.5, -100.0, 0.0], 1.183_291_357_831_522_3e-30),
    ("length(vec3f(x, y, z))", [2.0, 3.0, 6.0], 7.0),
    ("length(x)", [-2.0, 0.0, 0.0], 2.0),
    ("log(x)", [10.0, 0.0, 0.0], core::f64::consts::LN_10),
    ("log2(x)", [8.0, 0.0, 0.0], 3.0),
    ("max(x, y)", [1.0, 2.0, 0.0], 2.0),
    ("min(x, y)", [1.0, 2.0, 0.0], 1.0),
    ("mix(x, y, z)", [1.0, 3.0, 0.25], 1.5),
    ("mix(vec2f(x, y), vec2f(y, x), z).y", [1.0, 3.0, 0.25], 2.5),
    ("modf(x).fract", [-1.75, 0.0, 0.0], -0.75),
    ("modf(x).whole", [-1.75, 0.0, 0.0], -1.0),
    ("normalize(vec2f(x, y)).y", [3.0, 4.0, 0.0], 0.8),
    ("pow(x, y)", [2.0, 10.0, 0.0], 1024.0),
    ("quantizeToF16(x)", [1.0, 0.0, 0.0], 1.0),
    ("quantizeToF16(x)", [0.0, 0.0, 0.0], 0.0),
    ("quantizeToF16(x)", [0.1, 0.0, 0.0], 0.099_975_585_937_5),
    ("radians(x)", [90.0, 0.0, 0.0], FRAC_PI_2),
    ("reflect(vec2f(x, y), vec2f(0.0, 1.0)).y", [1.0, -2.0, 0.0], 2.0),
    ("refract(vec2f(x, y), vec2f(0.0, 1.0), z).y", [0.0, -1.0, 0.5], -1.0),
    ("refract(vec2f(x, y), vec2f(0.0, 1.0), z).x", [0.6, -0.8, 0.5], 0.3),
    ("refract(vec2f(x, y), vec2f(0.0, 1.0), z).x", [0.8, -0.6, 2.0], 0.0),
    ("round(x)", [2.5, 0.0, 0.0], 2.0),
    ("round(x)", [3.5, 0.0, 0.0], 4.0),
    ("round(x)", [-0.75, 0.0, 0.0], -1.0),
    ("saturate(x)", [1.5, 0.0, 0.0], 1.0),
    ("select(x, y, z > 0.0)", [1.0, 2.0, 1.0], 2.0),
    ("select(vec2f(x, y), vec2f(y, x), vec2<bool>(z > 0.0, z < 0.0)).y", [1.0, 2.0, 1.0], 2.0),
    ("sign(x)", [-0.5, 0.0, 0.0], -1.0),
    ("sign(x)", [0.0, 0.0, 0.0], 0.0),
    ("sin(x)", [1.0, 0.0, 0.0], 0.841_470_984_807_896_5),
    ("sinh(x)", [1.0, 0.0, 0.0], 1.175_201_193_643_801_4),
    ("smoothstep(x, y, z)", [1.0, 3.0, 1.5], 0.156_25),
    ("smoothstep(x, y, z)", [1.0, 3.0, 5.0], 1.0),
    ("sqrt(x)", [2.0, 0.0, 0.0], core::f64::consts::SQRT_2),
    ("step(x, y)", [1.0, 1.0, 0.0], 1.0),
    ("step(x, y)", [1.0, 0.5, 0.0], 0.0),
    ("tan(x)", [1.0, 0.0, 0.0], 1.557_407_724_654_902_3),
    ("tanh(x)", [0.5, 0.0, 0.0], 0.462_117_157_260_009_76),
    ("transpose(mat2x3f(x, y, z, 4.0, 5.0, 6.0))[1].x", [1.0, 2.0, 3.0], 2.0),
    ("transpose(mat2x3f(x, y, z, 4.0, 5.0, 6.0))[1].y", [1.0, 2.0, 3.0], 5.0),
    ("trunc(x)", [-1.75, 0.0, 0.0], -1.0),
    ("(mat2x3f(x, y, z, 4.0, 5.0, 6.0) * vec2f(x, y)).z", [1.0, 2.0, 3.0], 15.0),
    ("(vec3f(x, y, z) * mat2x3f(x, y, z, 4.0, 5.0, 6.0)).y", [1.0, 2.0, 3.0], 32.0),
    ("(mat2x2f(x, y, z, 4.0) * mat2x2f(5.0, 6.0, 7.0, 8.0))[1].x", [1.0, 2.0, 3.0], 31.0),
    ("(mat2x2f(x, y, z, 4.0) * y)[1].y", [1.0, 2.0, 3.0], 8.0),
    ("vec4f(x, y, z, 4.0).wzyx.yz.x", [1.0, 2.0, 3.0], 3.0),
    ("array<f32, 3>(x, y, z)[u32(y)]", [1.0, 2.0, 3.0], 3.0),
    ("vec3f(x, y, z)[i32(x)]", [1.0, 2.0, 3.0], 2.0),
    ("unpack4x8snorm(pack4x8snorm(vec4f(x, y, z, 1.0))).y", [0.0, -1.0, 0.3], -1.0),
    ("unpack4x8unorm(pack4x8unorm(vec4f(x, y, z, 1.0))).z", [0.0, -1.0, 0.2], 51.0 / 255.0),
    ("unpack2x16snorm(pack2x16snorm(vec2f(x, y))).x", [0.25, -1.0, 0.2], 8192.0 / 32767.0),
    ("unpack2x16unorm(pack2x16unorm(vec2f(x, y))).x", [0.2, -1.0, 0.2], 13107.0 / 65535.0),
    ("unpack2x16float(pack2x16float(vec2f(x, y))).y", [0.2, -1.5, 0.2], -1.5),
    ("f32(u32(x))", [-3.7, 0.0, 0.0], 0.0),
    ("f32(u32(x))", [3.7, 0.0, 0.0], 3.0),
    ("f32(i32(x))", [-3.7, 0.0, 0.0], -3.0),
    ("f32(bool(x))", [-3.7, 0.0, 0.0], 1.0),
    ("bitcast<f32>(bitcast<u32>(x) ^ 0x80000000u)", [3.0, 0.0, 0.0], -3.0),
    ("exp(log(x) * y)", [2.0, LN_2 as f32, 0.0], 1.616_806_614_4),
];

const WHOLES: &[Whole] = &[
    ("bitcast<u32>(i + j)", [0x7fff_ffff, 1, 0, 0], LEAST),
    ("bitcast<u32>(i - j)", [LEAST, 1, 0, 0], 0x7fff_ffff),
    ("bitcast<u32>(i * j)", [0x1_0001, 0x1_0001, 0, 0], 0x2_0001),
    ("bitcast<u32>(i / j)", [7, MINUS_ONE, 0, 0], (-7i32) as u32),
    ("bitcast<u32>(i / j)", [(-7i32) as u32, 2, 0, 0], (-3i32) as u32),
    ("bitcast<u32>(i / j)", [7, 0, 0, 0], 7),
    ("bitcast<u32>(i / j)", [LEAST, MINUS_ONE, 0, 0], LEAST),
    ("bitcast<u32>(i % j)", [(-7i32) as u32, 2, 0, 0], MINUS_ONE),
    ("bitcast<u32>(i % j)", [7, 0, 0, 0], 0),
    ("bitcast<u32>(i % j)", [LEAST, MINUS_ONE, 0, 0], 0),
    ("bitcast<u32>(-i)", [LEAST, 0, 0, 0], LEAST),
    ("u / v", [0, 0, 7, 0], 7),
    ("u % v", [0, 0, 7, 0], 0),
    ("u - v", [0, 0, 1, 2], MINUS_ONE),
    ("u << v", [0, 0, 3, 31], LEAST),
    ("u << (v & 31u)", [0, 0, 3, 33], 6),
    ("u >> v", [0, 0, LEAST, 31], 1),
    ("bitcast<u32>(i >> v)", [LEAST, 0, 0, 31], MINUS_ONE),
    ("~u & v | u ^ v", [0, 0, 12, 10], 6),
    ("u32(i < j) + 2u * u32(u < v)", [MINUS_ONE, 1, MINUS_ONE, 1], 1),
    ("u32(i >= j) + 2u * u32(u >= v) + 4u * u32(i == j) + 8u * u32(u != v)", [MINUS_ONE, 1, MINUS_ONE, 1], 10),
    ("bitcast<u32>(abs(i))", [LEAST, 0, 0, 0], LEAST),
    ("bitcast<u32>(abs(i))", [(-5i32) as u32, 0, 0, 0], 5),
    ("abs(u)", [0, 0, LEAST, 0], LEAST),
    ("bitcast<u32>(sign(i))", [LEAST, 0, 0, 0], MINUS_ONE),
    ("bitcast<u32>(min(i, j))", [LEAST, 1, 0, 0], LEAST),
    ("min(u, v)", [0, 0, LEAST, 1], 1),
    ("bitcast<u32>(max(i, j))", [LEAST, 1, 0, 0], 1),
    ("bitcast<u32>(clamp(i, j, 5))", [9, 1, 0, 0], 5),
    ("clamp(u, v, 5u)", [0, 0, 0, 2], 2),
    ("countLeadingZeros(u)", [0, 0, 1, 0], 31),
    ("countLeadingZeros(u)", [0, 0, 0, 0], 32),
    ("countTrailingZeros(u)", [0, 0, 8, 0], 3),
    ("countTrailingZeros(u)", [0, 0, 0, 0], 32),
    ("countOneBits(u)", [0, 0, 0xff00_ff01, 0], 17),
    ("reverseBits(u)", [0, 0, 1, 0], LEAST),
    ("firstLeadingBit(u)", [0, 0, 0, 0], MINUS_ONE),
    ("firstLeadingBit(u)", [0, 0, 9, 0], 3),
    ("bitcast<u32>(firstLeadingBit(i))", [MINUS_ONE, 0, 0, 0], MINUS_ONE),
    ("bitcast<u32>(firstLeadingBit(i))", [(-9i32) as u32, 0, 0, 0], 3),
    ("firstTrailingBit(u)", [0, 0, 0, 0], MINUS_ONE),
    ("firstTrailingBit(u)", [0, 0, 24, 0], 3),
    ("extractBits(u, v, 8u)", [0, 0, 0xabcd_1234, 4], 0x23),
    ("extractBits(u, v, 8u)", [0, 0, 0xabcd_1234, 28], 0xa),
    ("extractBits(u, 0u, v)", [0, 0, 0xabcd_1234, 0], 0),
    ("bitcast<u32>(extractBits(i, 4u, v))", [0xf0, 0, 0, 4], MINUS_ONE),
    ("insertBits(u, v, 8u, 4u)", [0, 0, 0xffff_ffff, 5], 0xffff_f5ff),
    ("insertBits(u, v, 30u, 8u)", [0, 0, 0, 7], 0xc000_0000),
    ("insertBits(u, v, 4u, 0u)", [0, 0, 3, 7], 3),
    ("dot(vec2u(u, v), vec2u(v, 3u))", [0, 0, 5, 7], 56),
    ("dot4U8Packed(u, v)", [0, 0, 0x0102_03ff, 0x0101_01ff], 65031),
    ("bitcast<u32>(dot4I8Packed(u, v))", [0, 0, 0x0102_03ff, 0x0101_01ff], 7),
    ("pack4xU8(vec4u(u, v, 3u, 4u))", [0, 0, 0x101, 2], 0x0403_0201),
    ("pack4xI8(vec4i(i, j, 3, 4))", [MINUS_ONE, 2, 0, 0], 0x0403_02ff),
    ("pack4xU8Clamp(vec4u(u, v, 3u, 4u))", [0, 0, 0x101, 2], 0x0403_02ff),
    ("pack4xI8Clamp(vec4i(i, j, 3, 4))", [(-1000i32) as u32, 1000, 0, 0], 0x0403_7f80),
    ("bitcast<u32>(unpack4xI8(u).y)", [0, 0, 0x0403_ff01, 0], MINUS_ONE),
    ("unpack4xU8(u).y", [0, 0, 0x0403_ff01, 0], 255),
    ("u32(all(vec2u(u, v) > vec2u(1u, 1u))) + 2u * u32(any(vec2u(u, v) > vec2u(1u, 1u)))", [0, 0, 1, 2], 2),
    ("pack4x8snorm(vec4f(f32(i), 0.5, -0.25, 2.0))", [MINUS_ONE, 0, 0, 0], 0x7fe0_4081),
    ("pack2x16float(vec2f(f32(u), -2.0))", [0, 0, 1, 0], 0xc000_3c00),
    ("pack2x16float(vec2f(f32(u), f32(v)))", [0, 0, 0, 1], 0x3c00_0000),
    ("u32(f32(u))", [0, 0, 0xffff_ff00, 0], 0xffff_ff00),
    ("bitcast<u32>(i32(f32(u)))", [0, 0, 0xffff_ff00, 0], 0x7fff_ff80),
    ("u32(bool(u)) + u32(bool(i))", [0, 0, 5, 0], 1),
    ("bitcast<u32>(f32(i))", [(-2i32) as u32, 0, 0, 0], 0xc000_0000),
];

fn real_source(expression: &str) -> String {
    format!("fn f(x: f32, y: f32, z: f32) -> f32 {{ return {expression}; }}")
}

fn whole_source(expression: &str) -> String {
    format!("fn f(i: i32, j: i32, u: u32, v: u32) -> u32 {{ return {expression}; }}")
}

/// The only result of `f` for one row.
fn value<N: brdf::shader::interp::Number>(shader: &Shader, cells: &[Cell<N>], what: &str) -> Cell<N> {
    let program = Program::new(shader, "f").unwrap_or_else(|error| panic!("{what}: {error}"));
    program.run(cells, &mut Buffers::new()).unwrap_or_else(|error| panic!("{what}: {error}"))[0]
}

#[test]
fn real_builtins_have_the_values_of_the_specification() {
    let gpus = adapters_for_tests();
    for (expression, arguments, want) in REALS {
        let source = real_source(expression);
        let single = Shader::parse(&source).unwrap_or_else(|error| panic!("{expression}: {error}"));
        let double = Shader::in_double(&source).unwrap_or_else(|error| panic!("{expression}: {error}"));
        let Cell::Real(got) = value(&single, &arguments.map(Cell::Real), expression) else { panic!("{expression}") };
        assert!((f64::from(got) - want).abs() <= 4e-6 * want.abs(), "{expression} {arguments:?} = {got}, not {want}");
        let Cell::Real(got) = value(&double, &arguments.map(|x| Cell::Real(f64::from(x))), expression) else {
            panic!()
        };
        // Arguments that f32 rounds, and what goes through bits, keep f32's error.
        assert!((got - want).abs() <= 3e-7 * want.abs(), "{expression} {arguments:?} = {got} in f64, not {want}");
        let cells = arguments.map(|x| Cell::Real(WgslInterval::exactly(x)));
        let Cell::Real(allowed) = value(&double, &cells, expression) else { panic!("{expression}") };
        let f = |x: f64| x as f32;
        let inside = [f(*want).next_down(), f(*want), f(*want).next_up()].iter().any(|x| allowed.contains(*x));
        assert!(inside, "{expression} {arguments:?}: {want} outside {allowed:?}");
        for gpu in &gpus {
            // naga's GLSL leaves a conversion out of range to the driver.
            if *expression == "f32(u32(x))" && arguments[0] < 0.0 && gpu.info().to_string().contains("[GL]") {
                continue;
            }
            let got = Kernel::new(gpu, &source, "f", None).and_then(|kernel| kernel.run_f32(arguments, &[]));
            let got = got.unwrap_or_else(|error| panic!("{expression}: {error}"))[0];
            assert!(allowed.contains(got), "{expression} {arguments:?} = {got} on {}, allowed {allowed:?}", gpu.info());
        }
    }
}

#[test]
fn whole_builtins_have_the_values_of_the_specification() {
    let gpus = adapters_for_tests();
    for (expression, arguments, want) in WHOLES {
        let source = whole_source(expression);
        let single = Shader::parse(&source).unwrap_or_else(|error| panic!("{expression}: {error}"));
        let got = value::<f32>(&single, &arguments.map(Cell::Word), expression);
        assert_eq!(got, Cell::Word(*want), "{expression} {arguments:x?}, want {want:x}");
        for gpu in &gpus {
            let got = Kernel::new(gpu, &source, "f", None).and_then(|kernel| kernel.run(arguments, &[]));
            let got = got.unwrap_or_else(|error| panic!("{expression}: {error}"))[0];
            // What a device does beyond the types' ranges is told, not judged.
            if got != *want {
                println!("{expression} {arguments:x?} = {got:x} on {}, not {want:x}", gpu.info());
            }
        }
    }
}
