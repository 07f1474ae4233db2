//! Columns of numbers as rows of words, and back.
//!
//! A caller holds one array for each argument (structure of arrays); a kernel reads all arguments of a row together.

use super::GpuError;

/// Interleaves columns of f32 into rows of words: `[a0, b0, a1, b1, …]` from `[[a0, a1, …], [b0, b1, …]]`.
///
/// # Errors
/// [`GpuError::Arguments`] where the columns differ in length.
pub fn rows(columns: &[&[f32]]) -> Result<Vec<u32>, GpuError> {
    let length = columns.first().map_or(0, |column| column.len());
    if let Some((index, column)) = columns.iter().enumerate().find(|(_, column)| column.len() != length) {
        let reason = format!("column {index} has {} numbers, column 0 has {length}", column.len());
        return Err(GpuError::Arguments { function: "rows".to_owned(), reason });
    }
    let mut rows = Vec::with_capacity(length * columns.len());
    for row in 0..length {
        rows.extend(columns.iter().map(|column| column[row].to_bits()));
    }
    Ok(rows)
}

/// Splits rows of `words` words into columns of f32, the inverse of [`rows`]; words after the last whole row are dropped.
pub fn columns(rows: &[u32], words: usize) -> Vec<Vec<f32>> {
    let column = |index| rows.chunks_exact(words).map(|row| f32::from_bits(row[index])).collect();
    (0..words).map(column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_and_rows_are_inverse() {
        let words = rows(&[&[1.0, 2.0, 3.0], &[-1.0, 0.0, f32::INFINITY]]).unwrap();
        assert_eq!(words[..2], [1.0f32.to_bits(), (-1.0f32).to_bits()]);
        assert_eq!(columns(&words, 2), [[1.0, 2.0, 3.0], [-1.0, 0.0, f32::INFINITY]]);
        assert!(rows(&[]).unwrap().is_empty());
        assert_eq!(columns(&[], 0), Vec::<Vec<f32>>::new());
        let error = rows(&[&[1.0], &[]]).unwrap_err().to_string();
        assert_eq!(error, "`rows`: column 1 has 0 numbers, column 0 has 1");
    }
}
