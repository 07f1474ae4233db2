//! Intervals: every value that WGSL allows, and not many more.

use brdf::interval::{AccuracyTable, Interval, WgslInterval};
use brdf::shader::interp::{Cell, Number, Program, Shader};

pub(crate) fn run<N: Number>(source: &str, function: &str, arguments: &[Cell<N>]) -> Vec<Cell<N>> {
    let shader = Shader::in_double(source).unwrap_or_else(|error| panic!("{error}\n{source}"));
    let program = Program::new(&shader, function).unwrap_or_else(|error| panic!("{error}\n{source}"));
    program.run(arguments, &mut Default::default()).unwrap_or_else(|error| panic!("{error}\n{source}"))
}

fn one(source: &str, arguments: &[f32]) -> WgslInterval {
    let cells: Vec<_> = arguments.iter().map(|x| Cell::Real(WgslInterval::exactly(*x))).collect();
    match run(source, "f", &cells)[..] {
        [Cell::Real(interval)] => interval,
        ref other => panic!("{other:?}"),
    }
}

/// x within about 1 ULP, so that a comparison with it stays open.
const VAGUE: &str = "fn vague(x: f32) -> f32 { return x * 1.3 / 1.3; }\n";

#[test]
fn an_open_branch_goes_both_ways() {
    let source = format!("{VAGUE}fn f(x: f32) -> f32 {{ if vague(x) < x {{ return 1.0; }} return 2.0; }}");
    let both = one(&source, &[0.7]);
    assert_eq!((both.low(), both.high()), (1.0, 2.0));
    let source = format!("{VAGUE}fn f(x: f32) -> f32 {{ if vague(x) < 2.0 * x {{ return 1.0; }} return 2.0; }}");
    assert_eq!(one(&source, &[0.7]), WgslInterval::exactly(1.0));
}

#[test]
fn variables_of_open_branches_are_joined_and_do_not_leak() {
    let source = format!(
        "{VAGUE}fn f(x: f32) -> f32 {{
            var a = array<f32, 2>(5.0, 6.0);
            if vague(x) < x {{ a[0] = 1.0; var b = 9.0; a[1] = b; }} else {{ a[0] = 2.0; }}
            return a[0] * 10.0 + a[1];
        }}"
    );
    // 1·10+9 and 2·10+6, never 2·10+9.
    let result = one(&source, &[0.7]);
    assert!(
        result.contains(19.0) && result.contains(26.0) && result.high() < 27.0 && result.low() > 18.0,
        "{result:?}"
    );
}

#[test]
fn open_loops_end_or_are_unbounded() {
    let source = format!(
        "{VAGUE}fn f(x: f32) -> f32 {{
            var n = 0.0;
            for (var i = 0; i < 5; i++) {{ if vague(x) < x {{ break; }} n += 1.0; }}
            return n;
        }}"
    );
    let result = one(&source, &[0.7]);
    assert!(result.contains(0.0) && result.contains(5.0) && result.high() < 5.1, "{result:?}");

    let source = format!("{VAGUE}fn f(x: f32) -> f32 {{ var n = 0.0; while vague(n) <= n {{ n += 1.0; }} return n; }}");
    assert!(!one(&source, &[0.7]).is_bounded());
}

#[test]
fn whole_numbers_that_are_open_take_every_value() {
    let source = format!("{VAGUE}fn f(x: f32) -> f32 {{ return f32(u32(vague(x))) * 100.0; }}");
    let result = one(&source, &[3.0]);
    assert!(result.contains(200.0) && result.contains(300.0) && result.high() < 301.0, "{result:?}");
    let source = format!("{VAGUE}fn f(x: f32) -> f32 {{ return f32(bitcast<u32>(vague(x)) & 1u); }}");
    assert!(!one(&source, &[3.0]).is_bounded());
}

/// FORMULAS §4: the form decides the tolerance.
#[test]
fn the_form_decides_the_width() {
    let head = "const pi: f32 = 3.14159265358979324;\n";
    let lost = format!(
        "{head}fn f(c: f32, a: f32) -> f32 {{ let d = c * c * (a * a - 1.0) + 1.0; return a * a / (pi * d * d); }}"
    );
    let kept = format!(
        "{head}fn f(c: f32, a: f32) -> f32 {{
            let s = (1.0 - c) * (1.0 + c); let r = a / (s + a * a * c * c); return r * r / pi;
        }}"
    );
    let relative = |source: &str| {
        let interval = one(source, &[0.99999, 0.01]);
        (interval.high() - interval.low()) / (interval.high() + interval.low())
    };
    let (lost, kept) = (relative(&lost), relative(&kept));
    assert!(lost > 1e-3 && lost < 1e-2, "{lost:e}");
    assert!(kept < 3e-6, "{kept:e}");
}

/// A table of which one row is set by hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Narrow;
impl AccuracyTable for Narrow {
    const QUOTIENT: f64 = 1e-4;
}
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Wide;
impl AccuracyTable for Wide {
    const QUOTIENT: f64 = 100.0;
}

/// A quotient that is 2 ULP off is allowed, one that is 20 ULP off is not; other tables say otherwise.
#[test]
fn the_table_decides_the_verdict() {
    fn quotient<T: AccuracyTable>() -> Interval<T> {
        let cells = [1.3f32, 0.7].map(|x| Cell::Real(Interval::<T>::exactly(x)));
        match run("fn f(a: f32, b: f32) -> f32 { return a / b; }", "f", &cells)[..] {
            [Cell::Real(interval)] => interval,
            ref other => panic!("{other:?}"),
        }
    }
    let right = 1.3f32 / 0.7;
    let off = |ulps: i32| f32::from_bits(right.to_bits().wrapping_add_signed(ulps));
    let wgsl = quotient::<brdf::interval::Wgsl>();
    assert!(wgsl.contains(off(2)) && wgsl.contains(off(-2)) && !wgsl.contains(off(20)));
    let narrow = quotient::<Narrow>();
    assert!(!narrow.contains(off(2)) && !narrow.contains(off(-2)));
    let wide = quotient::<Wide>();
    assert!(wide.contains(off(20)) && !wide.contains(off(200)));
}
