//! The GPU runner on every adapter of the machine.
#![cfg(feature = "gpu")]

mod adapters;

use adapters::adapters_for_tests;
use brdf::gpu::{Gpu, GpuError, Kernel, columns, rows, wgpu};

fn kernel(gpu: &Gpu, source: &str, function: &str) -> Kernel {
    Kernel::new(gpu, source, function, None).unwrap_or_else(|error| panic!("{}: {error}", gpu.info()))
}

fn refusal(result: Result<Kernel, GpuError>) -> String {
    result.map(|kernel| kernel.signature().to_string()).unwrap_err().to_string()
}

#[test]
fn every_adapter_opens_by_its_own_name() {
    for gpu in adapters_for_tests() {
        let name = gpu.info().to_string();
        assert_eq!(Gpu::open(Some(&name)).unwrap().info(), gpu.info());
        assert_eq!(Gpu::open(Some(gpu.info().backend_name())).unwrap().info().backend, gpu.info().backend);
    }
    assert_eq!(brdf::gpu::adapters(), brdf::gpu::adapters());
    let error = Gpu::open(Some("no such adapter")).unwrap_err();
    assert!(matches!(error, GpuError::NoAdapter { .. }));
    assert!(error.to_string().contains("`no such adapter`") && error.to_string().contains("apt-get"), "{error}");
}

#[test]
fn scalars_and_columns() {
    let source = "fn scale(x: f32, by: f32) -> f32 { return x * by; }";
    for gpu in adapters_for_tests() {
        let scale = kernel(&gpu, source, "scale");
        let x: Vec<f32> = (0..1000).map(|i| i as f32).collect();
        let by = vec![0.5; 1000];
        let results = columns(&scale.run(&rows(&[&x, &by]).unwrap(), &[]).unwrap(), 1);
        let want: Vec<f32> = x.iter().map(|x| x * 0.5).collect();
        assert_eq!(results, [want], "{}", gpu.info());
        assert_eq!(scale.run_f32(&[3.0, 2.0, 5.0, 4.0], &[]).unwrap(), [6.0, 20.0], "{}", gpu.info());
        assert!(scale.run(&[], &[]).unwrap().is_empty(), "{}", gpu.info());
        assert!(scale.run_f32(&[], &[]).unwrap().is_empty(), "{}", gpu.info());
    }
}

#[test]
fn vectors_in_and_out() {
    let source = "fn cross_of(a: vec3<f32>, b: vec3f) -> vec3<f32> { return cross(a, b); }";
    for gpu in adapters_for_tests() {
        let input = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 3.0, 0.0, 0.0];
        let output = kernel(&gpu, source, "cross_of").run_f32(&input, &[]).unwrap();
        assert_eq!(output, [0.0, 0.0, 1.0, 0.0, 6.0, 0.0], "{}", gpu.info());
    }
}

#[test]
fn structs_with_nested_members() {
    let source = "
        struct Ray { w: vec3<f32>, hit: bool }
        struct Fresnel { reflectance: f32, ray: Ray, index: u32 }
        fn trace(ray: Ray, index: u32) -> Fresnel {
            return Fresnel(ray.w.z * 2.0, Ray(-ray.w, !ray.hit), index + 1u);
        }";
    for gpu in adapters_for_tests() {
        let trace = kernel(&gpu, source, "trace");
        let names: Vec<_> = trace.signature().outputs().into_iter().map(|leaf| leaf.name).collect();
        assert_eq!(names, ["reflectance", "ray.w.x", "ray.w.y", "ray.w.z", "ray.hit", "index"]);
        let f = f32::to_bits;
        let input = [f(1.0), f(2.0), f(3.0), 7, 41, f(4.0), f(5.0), f(6.0), 0, u32::MAX];
        let want = [f(6.0), f(-1.0), f(-2.0), f(-3.0), 0, 42, f(12.0), f(-4.0), f(-5.0), f(-6.0), 1, 0];
        assert_eq!(trace.run(&input, &[]).unwrap(), want, "{}", gpu.info());
        let error = trace.run_f32(&[0.0; 5], &[]).unwrap_err().to_string();
        assert_eq!(error, "`trace`: `ray.hit` is bool, not f32: pass words");
    }
}

#[test]
fn integers_and_booleans() {
    let source = "
        struct Result { sum: i32, bits: u32, both: bool, small: vec2<bool>, v: vec4<i32> }
        fn mix_up(a: i32, b: u32, c: bool, v: vec2<i32>, m: vec3<bool>) -> Result {
            return Result(a - 1, b ^ 0xffffffffu, c && m.y, v < vec2(0), vec4<i32>(v, v.yx));
        }";
    for gpu in adapters_for_tests() {
        let n = |x: i32| x as u32;
        let input = [n(i32::MIN + 1), 0x1234_5678, 1, n(-5), 9, 0, 256, 1];
        let want = [n(i32::MIN), 0xedcb_a987, 1, 1, 0, n(-5), 9, 9, n(-5)];
        assert_eq!(kernel(&gpu, source, "mix_up").run(&input, &[]).unwrap(), want, "{}", gpu.info());
    }
}

#[test]
fn matrices_and_arrays() {
    let source = "
        fn turn(m: mat2x3<f32>, v: array<vec2<f32>, 2>) -> array<vec3<f32>, 2> {
            return array<vec3<f32>, 2>(m * v[0], m * v[1]);
        }
        struct Table { m: mat3x2<f32>, rest: array<u32, 3> }
        fn transposed(m: mat2x3<f32>, i: u32) -> Table {
            return Table(transpose(m), array<u32, 3>(i, i + 1u, i + 2u));
        }";
    for gpu in adapters_for_tests() {
        // Columns (1,2,3) and (4,5,6).
        let m = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let turn = kernel(&gpu, source, "turn");
        let output = turn.run_f32(&[m.as_slice(), &[1.0, 0.0, 0.5, 2.0]].concat(), &[]).unwrap();
        assert_eq!(output, [1.0, 2.0, 3.0, 8.5, 11.0, 13.5], "{}", gpu.info());
        assert_eq!(turn.signature().outputs()[3].name, "value[1].x");

        let input: Vec<u32> = m.iter().map(|x| x.to_bits()).chain([7]).collect();
        let output = kernel(&gpu, source, "transposed").run(&input, &[]).unwrap();
        let want: Vec<u32> = [1.0f32, 4.0, 2.0, 5.0, 3.0, 6.0].iter().map(|x| x.to_bits()).chain([7, 8, 9]).collect();
        assert_eq!(output, want, "{}", gpu.info());
    }
}

#[test]
fn storage_completes_the_module() {
    // As the layered twins do: they call a function that the embedder supplies.
    let source = "
        struct Layer { eta: vec3<f32>, alpha: f32 }
        fn eta_of(index: u32, scale: f32) -> vec3<f32> { return stack_layer(index).eta * scale; }";
    let bindings = "
        @group(0) @binding(3) var<storage, read> stack_layers: array<Layer>;
        fn stack_layer(i: u32) -> Layer { return stack_layers[i]; }";
    let layers: Vec<u8> = [1.0f32, 2.0, 3.0, 0.1, 4.0, 5.0, 6.0, 0.2].iter().flat_map(|x| x.to_le_bytes()).collect();
    for gpu in adapters_for_tests() {
        let kernel = Kernel::new(&gpu, source, "eta_of", Some(bindings)).unwrap();
        let output = kernel.run(&[1, 2f32.to_bits(), 0, 1f32.to_bits()], &[&layers]).unwrap();
        assert_eq!(columns(&output, 3), [[8.0, 1.0], [10.0, 2.0], [12.0, 3.0]], "{}", gpu.info());
        for (storage, why) in [(&[][..], "none given"), (&[&[][..]][..], "0 bytes"), (&[&layers[..30]][..], "30 bytes")]
        {
            let error = kernel.run(&[0, 0], storage).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
        // Less than one element of the array: refused by the device, not by a crash.
        let error = kernel.run(&[0, 0], &[&layers[..4]]).unwrap_err();
        assert!(matches!(error, GpuError::Rejected { .. }), "{error}");
        // And the device still works.
        assert!(kernel.run(&[0, 0], &[&layers]).is_ok());

        // A bare constant in place of the buffer needs no storage.
        let constant = "fn stack_layer(i: u32) -> Layer { return Layer(vec3<f32>(f32(i)), 0.5); }";
        let kernel = Kernel::new(&gpu, source, "eta_of", Some(constant)).unwrap();
        assert_eq!(columns(&kernel.run(&[3, 2f32.to_bits()], &[]).unwrap(), 3), [[6.0], [6.0], [6.0]]);
        assert!(kernel.run(&[3, 0], &[&layers]).unwrap_err().to_string().contains("no storage buffer"));
    }
}

#[test]
fn several_storage_buffers_are_bound_by_order() {
    let source = "fn pick(i: u32) -> f32 { return first(i) * 10.0 + last(i); }";
    // The order of declaration does not count, and bindings may be left out.
    let bindings = "
        @group(0) @binding(6) var<storage, read> b: array<f32>;
        @group(0) @binding(4) var<storage, read> a: array<f32>;
        fn first(i: u32) -> f32 { return a[i]; }
        fn last(i: u32) -> f32 { return b[i]; }";
    let bytes = |values: [f32; 2]| values.map(f32::to_le_bytes).concat();
    let (a, b) = (bytes([1.0, 2.0]), bytes([3.0, 4.0]));
    for gpu in adapters_for_tests() {
        let pick = Kernel::new(&gpu, source, "pick", Some(bindings)).unwrap();
        let output = pick.run(&[0, 1], &[&a, &b]).unwrap();
        assert_eq!(columns(&output, 1), [[13.0, 24.0]], "{}", gpu.info());
        for (storage, why) in
            [(&[&a[..]][..], "(binding 6): none"), (&[&a[..], &b, &a][..], "no storage buffer at binding 7")]
        {
            let error = pick.run(&[0], storage).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
    }
}

#[test]
fn more_rows_than_one_line_of_workgroups() {
    let source = "fn next(i: u32) -> u32 { return i * 3u + 1u; }";
    for gpu in adapters_for_tests() {
        // More than 65535·64 rows need a second line, more than 2²⁴ words a second dispatch.
        for rows in [65_535 * 64 + 1, (1 << 24) + 77] {
            let input: Vec<u32> = (0..rows).collect();
            let output = kernel(&gpu, source, "next").run(&input, &[]).unwrap();
            assert_eq!(output.len(), input.len());
            let wrong = input.iter().zip(&output).find(|(i, o)| **o != i.wrapping_mul(3).wrapping_add(1));
            assert_eq!(wrong, None, "{}", gpu.info());
        }
    }
}

#[test]
fn small_dispatches_give_the_same_results() {
    let source = "fn pair(a: f32, b: u32) -> vec3<f32> { return vec3<f32>(a, f32(b), a + f32(b)); }";
    for gpu in adapters_for_tests() {
        let input: Vec<u32> = (0..1001u32).flat_map(|i| [(i as f32).to_bits(), 2 * i]).collect();
        let whole = kernel(&gpu, source, "pair");
        let want = whole.run(&input, &[]).unwrap();
        assert_eq!(want[3 * 1000 + 2], 3000f32.to_bits(), "{}", gpu.info());
        for rows in [1, 64, 100, 1000, 1001] {
            assert_eq!(whole.clone().with_rows_per_dispatch(rows).run(&input, &[]).unwrap(), want, "{}", gpu.info());
        }
    }
}

#[test]
fn words_pass_unchanged() {
    let source = "
        fn same(a: u32, b: vec2<u32>) -> vec3<u32> { return vec3<u32>(a, b); }
        fn signed(a: i32, b: vec2<i32>) -> vec3<i32> { return vec3<i32>(a, b); }
        fn exponent(x: u32) -> bool { return (bitcast<u32>(bitcast<f32>(x)) >> 23u & 0xffu) == 255u; }";
    let quiet = f32::NAN.to_bits();
    let words = [quiet, 0x7f80_0001, 0xffff_ffff, 0x7f80_0000, 0xff80_0000, 1, 0x8000_0001, 0x007f_ffff, 0x8000_0000];
    for gpu in adapters_for_tests() {
        assert_eq!(kernel(&gpu, source, "same").run(&words, &[]).unwrap(), words, "{}", gpu.info());
        assert_eq!(kernel(&gpu, source, "signed").run(&words, &[]).unwrap(), words, "{}", gpu.info());
        let infinite = kernel(&gpu, source, "exponent").run(&[0x7f80_0000, 0x3f80_0000], &[]).unwrap();
        assert_eq!(infinite, [1, 0], "{}", gpu.info());
    }
}

#[test]
fn mistakes_are_errors_with_a_reason() {
    let source = "fn f(a: f32, b: vec2<f32>) -> f32 {\n    return a + b.x;\n}";
    for gpu in adapters_for_tests() {
        let new = |source, function| refusal(Kernel::new(&gpu, source, function, None));
        assert_eq!(new(source, "g"), "no function `g`: the module defines f");
        let error = new("fn f(a: f32) -> f32 {\n    return a + c;\n}", "f");
        assert!(error.starts_with("line 2, column 16: ") && error.contains('c'), "{error}");
        assert!(new("fn f() -> f32 { return 1.0; }", "f").contains("takes no arguments"));
        assert!(new("fn f(a: f32) {}", "f").contains("returns nothing"));
        assert!(new("fn f(a: f32, t: texture_2d<f32>) -> f32 { return a; }", "f").contains("`t` of `f` is a texture"));
        let error = Kernel::new(&gpu, source, "f", Some("fn broken( {")).unwrap_err().to_string();
        assert!(error.starts_with("line 4, column "), "{error}");

        let error = kernel(&gpu, source, "f").run(&[0; 4], &[]).unwrap_err().to_string();
        assert_eq!(error, "`f`: 4 words are no whole rows of 3 (a, b.x, b.y)");

        // Valid WGSL that this device has not enabled, and one whose globals collide with the kernel's.
        let wide = "fn f(a: f32) -> f32 { return f32(f64(a)); }";
        let error = Kernel::new(&gpu, wide, "f", None).unwrap_err();
        assert!(matches!(error, GpuError::Rejected { .. }), "{error}");
        let taken = "@group(0) @binding(0) var<storage, read> own: array<f32>;
            fn f(i: u32) -> f32 { return own[i]; }";
        let error = Kernel::new(&gpu, taken, "f", None).unwrap_err();
        assert!(matches!(error, GpuError::Rejected { .. }), "{error}");
    }
}

#[test]
fn a_device_of_ones_own_works_until_it_is_lost() {
    let source = "fn twice(x: f32) -> f32 { return 2.0 * x; }";
    for opened in adapters_for_tests() {
        let gpu = Gpu::from_device(opened.device().clone(), opened.queue().clone());
        assert_eq!(gpu.info().to_string(), opened.info().to_string());
        let twice = kernel(&gpu, source, "twice");
        assert_eq!(twice.run_f32(&[1.5], &[]).unwrap(), [3.0]);
        let of_opened = kernel(&opened, source, "twice");
        gpu.device().destroy();
        let _ = gpu.device().poll(wgpu::PollType::Poll);
        let compiled = Kernel::new(&gpu, source, "twice", None).map(|_| ()).unwrap_err();
        let ran = [&twice, &of_opened].map(|kernel| kernel.run_f32(&[1.5], &[]).unwrap_err());
        for error in ran.into_iter().chain([compiled]) {
            assert!(matches!(error, GpuError::Lost { .. }), "{error}");
        }
    }
}

#[test]
fn threads_share_a_device() {
    let source = "fn next(i: u32) -> u32 { return i + 1u; }";
    for gpu in adapters_for_tests() {
        std::thread::scope(|scope| {
            for start in 0..4u32 {
                let gpu = gpu.clone();
                scope.spawn(move || {
                    let next = kernel(&gpu, source, "next");
                    for _ in 0..5 {
                        let input: Vec<u32> = (start..start + 1000).collect();
                        let want: Vec<u32> = (start + 1..start + 1001).collect();
                        assert_eq!(next.run(&input, &[]).unwrap(), want, "{}", gpu.info());
                    }
                });
            }
        });
    }
}
