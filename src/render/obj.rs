//! Wavefront OBJ files: the corners of their triangles.
//!
//! Read are positions, texture coordinates, normals and faces (`v`, `vt`, `vn`, `f`), with indices that count from either end and lines that a
//! backslash continues. Faces of more than three corners become fans. What a corner does not name it does not have, whatever its neighbours
//! have. Names, groups, materials, lines, points and curves are passed over. +y, up in these files, becomes +z.
//!
//! Source: Wavefront Technologies 1992, "Advanced Visualizer Manual", appendix B1.

use super::mesh::Corner;
use std::borrow::Cow;

/// The triangles of a file's text.
///
/// # Errors
/// The line and what is wrong with it: a coordinate that is missing, no number, infinite or not a number; a face of fewer than three corners; an
/// index of something that is not there; a keyword in capitals. Of a file without faces the first line that no OBJ file has.
pub(super) fn triangles(text: &str) -> Result<Vec<[Corner; 3]>, String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // Lines of old Macs end with a carriage return alone.
    let old = text.contains('\r') && !text.contains('\n');
    let text = if old { Cow::Owned(text.replace('\r', "\n")) } else { Cow::Borrowed(text) };
    let mut file = File::default();
    let mut foreign = None;
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let mut line = without_comment(line).to_owned();
        while line.trim_end().ends_with('\\') {
            line.truncate(line.trim_end().len() - 1);
            let Some((_, next)) = lines.next() else { break };
            line.push(' ');
            line.push_str(without_comment(next));
        }
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { continue };
        let known = file.statement(keyword, words).map_err(|error| format!("line {}: {error}", number + 1))?;
        if !known && foreign.is_none() {
            foreign = Some((number + 1, keyword.chars().take(24).collect::<String>()));
        }
    }
    match foreign {
        Some((line, keyword)) if file.triangles.is_empty() => Err(format!(
            "line {line}: `{}` begins no line of an OBJ file; other formats are not read",
            keyword.escape_debug()
        )),
        _ => Ok(file.triangles),
    }
}

fn without_comment(line: &str) -> &str {
    line.split_once('#').map_or(line, |(before, _)| before)
}

/// What has been read.
#[derive(Default)]
struct File {
    positions: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    uvs: Vec<[f64; 2]>,
    triangles: Vec<[Corner; 3]>,
}

impl File {
    /// Reads a line; false of one that no OBJ file has.
    fn statement<'a>(&mut self, keyword: &str, words: impl Iterator<Item = &'a str>) -> Result<bool, String> {
        match keyword {
            // Weights and colours may follow a position, a third coordinate a texture's.
            "v" => self.positions.push(numbers(words, "x y z").map(upright)?),
            "vn" => self.normals.push(numbers(words, "x y z").map(upright)?),
            "vt" => self.uvs.push(texture(words)?),
            "f" | "fo" => self.face(words)?,
            "o" | "g" | "s" | "mg" | "p" | "l" | "usemtl" | "mtllib" | "usemap" | "maplib" | "vp" | "deg" | "bmat"
            | "step" | "cstype" | "curv" | "curv2" | "surf" | "parm" | "trim" | "hole" | "scrv" | "sp" | "end"
            | "con" | "bevel" | "c_interp" | "d_interp" | "lod" | "shadow_obj" | "trace_obj" | "ctech" | "stech"
            | "call" | "csh" => {}
            // Passed over, it would move every index that counts from the start.
            "V" | "VN" | "VT" | "F" | "Vn" | "Vt" => {
                return Err(format!("`{keyword}` is written in small letters in an OBJ file"));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<_>, _>>()?;
        let [first, rest @ ..] = corners.as_slice() else { return Err("a face has three corners at least".to_owned()) };
        if rest.len() < 2 {
            return Err(format!("a face has three corners at least, not {}", corners.len()));
        }
        self.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        Ok(())
    }

    /// A corner: position, position/uv, position//normal or position/uv/normal.
    fn corner(&self, word: &str) -> Result<Corner, String> {
        let mut indices = word.split('/');
        let mut next = || indices.next().filter(|index| !index.is_empty());
        let position = next().ok_or_else(|| format!("`{word}` names no vertex"))?;
        let (uv, normal) = (next(), next());
        Ok(Corner {
            position: *named(&self.positions, position, "vertex", "v")?,
            uv: uv.map(|index| named(&self.uvs, index, "texture coordinate", "vt").copied()).transpose()?,
            normal: normal.map(|index| named(&self.normals, index, "normal", "vn").copied()).transpose()?,
        })
    }
}

/// The entry of an index: from 1, or from −1 for the last so far.
fn named<'a, T>(all: &'a [T], index: &str, what: &str, keyword: &str) -> Result<&'a T, String> {
    let number: i64 = index.parse().map_err(|_| format!("`{index}` is no whole number: the index of a {what}"))?;
    let place = if number < 0 { all.len() as i64 + number } else { number - 1 };
    usize::try_from(place)
        .ok()
        .and_then(|place| all.get(place))
        .ok_or_else(|| format!("{what} {number} is not there; {} lines `{keyword}` come before", all.len()))
}

fn upright([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, -z, y]
}

fn numbers<'a, const N: usize>(mut words: impl Iterator<Item = &'a str>, names: &str) -> Result<[f64; N], String> {
    let mut found = [0.0; N];
    for number in &mut found {
        let word = words.next().ok_or_else(|| format!("a coordinate is missing; there are {names}"))?;
        let value: f64 = word.parse().map_err(|_| format!("`{word}` is no number"))?;
        if !value.is_finite() {
            return Err(format!("`{word}` is not finite"));
        }
        *number = value;
    }
    Ok(found)
}

/// Texture coordinates: u alone, where it is a curve's, has v = 0.
fn texture<'a>(words: impl Iterator<Item = &'a str>) -> Result<[f64; 2], String> {
    let words: Vec<&str> = words.take(2).collect();
    match words.as_slice() {
        [u] => numbers([*u].into_iter(), "u v").map(|[u]| [u, 0.0]),
        _ => numbers(words.into_iter(), "u v"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn faces_become_fans_with_y_upwards() {
        let read = triangles(&format!("{SQUARE}vt 0 0\nvt 1 0\nvn 0 0 1\nf 1/1/1 2/2/1 -2//-1 4\n")).expect("valid");
        let [[a, b, c], [d, e, f]] = read[..] else { panic!("{read:?}") };
        assert_eq!((a, c), (d, e));
        assert_eq!((a.position, c.position, f.position), ([0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]));
        assert_eq!((a.uv, b.uv, c.uv, f.uv), (Some([0.0, 0.0]), Some([1.0, 0.0]), None, None));
        assert_eq!((a.normal, c.normal, f.normal), (Some([0.0, -1.0, 0.0]), Some([0.0, -1.0, 0.0]), None));
    }

    #[test]
    fn lines_are_continued_and_comments_left_out() {
        let text = format!("# a square\r\no it\n{SQUARE}f 1 2 \\\n  3 \\\n4 # all\ns off\n");
        assert_eq!(triangles(&text).expect("valid").len(), 2);
        assert_eq!(triangles("v 0 0 0 \\").expect("valid").len(), 0);
        // A byte-order mark is no part of the first keyword.
        assert_eq!(triangles(&format!("\u{feff}{SQUARE}f 1 2 3\n")), triangles(&format!("{SQUARE}f 1 2 3\n")));
        assert_eq!(
            triangles(&format!("{SQUARE}f 1 2 3\n").replace('\n', "\r")),
            triangles(&format!("{SQUARE}f 1 2 3\n"))
        );
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, said) in [
            (format!("{SQUARE}f 1 2 7\n"), "line 5: vertex 7 is not there; 4 lines `v` come before"),
            (format!("{SQUARE}f 1 2 0\n"), "line 5: vertex 0 is not there; 4 lines `v` come before"),
            (
                format!("{SQUARE}\nf 1/1 2/1 3/1\n"),
                "line 6: texture coordinate 1 is not there; 0 lines `vt` come before",
            ),
            (format!("{SQUARE}f 1 2 \\\n-9\n"), "line 5: vertex -9 is not there; 4 lines `v` come before"),
            (format!("{SQUARE}f 1 2\n"), "line 5: a face has three corners at least, not 2"),
            (format!("{SQUARE}f 1 2 x\n"), "line 5: `x` is no whole number: the index of a vertex"),
            (format!("{SQUARE}f 1 2 /3\n"), "line 5: `/3` names no vertex"),
            (format!("{SQUARE}V 2 2 2\nf 1 2 3\n"), "line 5: `V` is written in small letters in an OBJ file"),
            ("v 0 0\n".to_owned(), "line 1: a coordinate is missing; there are x y z"),
            ("v 0 0 1e999\n".to_owned(), "line 1: `1e999` is not finite"),
            ("\nvt 0 a\n".to_owned(), "line 2: `a` is no number"),
            (
                "solid cube\nfacet normal 0 0 1\n".to_owned(),
                "line 1: `solid` begins no line of an OBJ file; other formats are not read",
            ),
            (
                "{\"asset\": {}}".to_owned(),
                "line 1: `{\\\"asset\\\":` begins no line of an OBJ file; other formats are not read",
            ),
        ] {
            assert_eq!(triangles(&text).expect_err(&text), said);
        }
    }
}
