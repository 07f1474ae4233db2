//! The flakes of a cell are the same flakes in Rust, in the text of the twin and on every adapter: to the bit, not to a tolerance.
#![cfg(feature = "gpu")]

mod adapters;

use adapters::adapters_for_tests;
use brdf::gpu::StackBuffers;
use brdf::material::glint;
use brdf::parity::{Draw, Twin, map_twin, text_single, twins};

const SAMPLES: u64 = 20_000;

fn leaf() -> Twin {
    let found = twins().into_iter().find(|twin| (twin.module, twin.function) == ("glint", "leaf"));
    found.expect("glint::leaf is in the parity table")
}

/// Cells, leaves, and up to 128 flakes: in half of the rows whole ones, in the others with a part of one.
fn rows() -> Vec<Vec<f32>> {
    let row = |index| {
        let mut row: Vec<f32> = (leaf().sample)(&mut Draw::new(index)).into_iter().map(|x| x as f32).collect();
        // The table draws up to 400.
        let count = row[4] * 0.32;
        row[4] = if index % 2 == 0 { count.floor() } else { count };
        row
    };
    (0..SAMPLES).map(row).collect()
}

#[test]
fn the_same_flakes_everywhere() {
    let (twin, rows, none) = (leaf(), rows(), StackBuffers::default());
    let want: Vec<f32> = rows.iter().flat_map(|row| (twin.single)(row)).collect();
    // Otherwise the test compares zeros.
    assert!(want.iter().filter(|held| **held > 0.0).count() > rows.len() / 4);
    let double: Vec<Vec<f64>> = rows.iter().map(|row| row.iter().copied().map(f64::from).collect()).collect();
    let text = text_single(&twin, &double, &none).expect("the text can be evaluated");
    for (index, (text, want)) in text.iter().zip(&want).enumerate() {
        assert_eq!(text[0], f64::from(*want), "{:?}", rows[index]);
    }
    for gpu in adapters_for_tests() {
        let outputs = map_twin(&gpu, &twin, &rows, &none).expect("a kernel that runs");
        for (index, (got, want)) in outputs.values.iter().zip(&want).enumerate() {
            assert_eq!(got.to_bits(), want.to_bits(), "{:?} on {}", rows[index], gpu.info());
        }
    }
}

/// Every leaf of a cell, on the adapter: what one gains the others lose.
#[test]
fn an_adapter_loses_no_flake() {
    const RESOLUTION: u32 = 5;
    let side = 1u32 << RESOLUTION;
    for gpu in adapters_for_tests() {
        for (cell, count) in [1.0f32, 3.25, 60.0, 128.0, 129.5, 5000.0].into_iter().enumerate() {
            let leaves = (0..side).flat_map(|i| (0..side).map(move |j| (i, j)));
            let row =
                |(i, j): (u32, u32)| vec![cell as f32, 11.0, 12.0, 13.0, count, RESOLUTION as f32, i as f32, j as f32];
            let rows: Vec<Vec<f32>> = leaves.map(row).collect();
            let outputs = map_twin(&gpu, &leaf(), &rows, &StackBuffers::default()).expect("a kernel that runs");
            let sum: f64 = outputs.values.iter().copied().map(f64::from).sum();
            // Exact up to 128; above each of nine splits of the same flakes may round by a root's 4.5 ULP and two sums.
            let tolerance = if count <= 128.0 { 0.0 } else { 9.0 * 8.0 * f64::from(f32::EPSILON) * f64::from(count) };
            assert!((sum - f64::from(count)).abs() <= tolerance, "{count} flakes, {sum} on {}", gpu.info());
            // The Rust function deals the same cell.
            let key = [cell as u32, 11, 12, 13];
            let ours: f64 =
                rows.iter().map(|r| glint::leaf(key, f64::from(count), RESOLUTION, r[6] as u32, r[7] as u32)).sum();
            assert!((ours - f64::from(count)).abs() <= 1e-11, "{ours}");
        }
    }
}
