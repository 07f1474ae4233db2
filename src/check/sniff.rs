//! What kind of file a subject comes in, by its content: extensions say little, `.brdf` and `.bsdf` least of all.
//!
//! ```
//! use brdf::check::sniff::{Kind, sniff};
//! assert_eq!(sniff(b"analytic\n::begin shader\n"), Ok(Kind::Explorer));
//! assert!(sniff(b"<?xml version=\"1.0\"?><WindowElement/>").unwrap_err().to_string().contains("XML"));
//! ```

use super::merl;
use core::fmt;

/// A kind of file that can be judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A layered stack, or a material of several, in TOML.
    Stack,
    /// Disney BRDF Explorer's analytic `.brdf`.
    Explorer,
    /// The MERL database's `.binary`.
    Merl,
    /// A module of WGSL, or of WESL.
    Wgsl,
    /// A shader of GLSL.
    Glsl,
}

impl Kind {
    /// What messages call it.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Stack => "stack or material file",
            Kind::Explorer => "BRDF Explorer file",
            Kind::Merl => "MERL file",
            Kind::Wgsl => "WGSL",
            Kind::Glsl => "GLSL",
        }
    }
}

/// A file that cannot be judged: displays as what it is and what could be given in its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// Nothing in it.
    Empty,
    /// A measured BRDF in a format that is known and not read yet, by its name.
    NotYet(&'static str),
    /// A format of another trade, by what it looks like.
    Foreign(&'static str),
    /// Bytes that are no text and of no known format.
    Binary,
    /// Text that is none of the languages.
    Text,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known = "a stack or material (TOML), a BRDF Explorer `.brdf`, a MERL `.binary`, WGSL or GLSL";
        match self {
            Refused::Empty => write!(f, "the file is empty: give {known}"),
            Refused::NotYet(format) => write!(f, "{format}: not supported yet; give {known}"),
            Refused::Foreign(format) => write!(f, "this looks like {format}, which is not judged: give {known}"),
            Refused::Binary => write!(f, "binary data of no known format: give {known}"),
            Refused::Text => write!(f, "text without a table, a shader function or a known first word: give {known}"),
        }
    }
}

impl std::error::Error for Refused {}

/// How much of a text is looked at.
const LOOKED_AT: usize = 1 << 20;
/// The bytes of a UTIA file: 288² pairs of directions, three channels of f64, no header.
const UTIA: usize = 288 * 288 * 3 * 8;

/// What kind of file these bytes are: all of the file, as some formats are known by their length alone.
///
/// A damaged file counts as the kind that it would be, so that its reader can name the damage.
///
/// # Errors
/// What the file is instead.
pub fn sniff(bytes: &[u8]) -> Result<Kind, Refused> {
    if bytes.is_empty() {
        return Err(Refused::Empty);
    }
    if let Some(refused) = magic(bytes) {
        return Err(refused);
    }
    let looked_at = bytes.get(..LOOKED_AT).unwrap_or(bytes);
    if looked_at.contains(&0) {
        return binary(bytes);
    }
    let text = String::from_utf8_lossy(looked_at);
    if text.chars().filter(|c| *c == '\u{fffd}').count() * 20 > text.len() {
        return binary(bytes);
    }
    of_text(&text)
}

/// Formats that start with a name of theirs.
fn magic(bytes: &[u8]) -> Option<Refused> {
    let known: [(&[u8], Refused); 9] = [
        (b"tensor_file\0", Refused::NotYet("RGL's measured BRDF (a tensor file, `.bsdf`)")),
        (b"\x89PNG", Refused::Foreign("a PNG image")),
        (b"\xff\xd8\xff", Refused::Foreign("a JPEG image")),
        (b"\x76\x2f\x31\x01", Refused::Foreign("an OpenEXR image")),
        (b"\x03\x02\x23\x07", Refused::Foreign("a SPIR-V module: give its source")),
        (b"PK\x03\x04", Refused::Foreign("a zip archive")),
        (b"\x1f\x8b", Refused::Foreign("a gzip archive")),
        (b"\x89HDF", Refused::Foreign("an HDF5 file")),
        (b"%PDF", Refused::Foreign("a PDF document")),
    ];
    known.into_iter().find(|(start, _)| bytes.starts_with(start)).map(|(_, refused)| refused)
}

fn binary(bytes: &[u8]) -> Result<Kind, Refused> {
    let word = |index: usize| {
        let word = bytes.get(4 * index..4 * index + 4)?;
        word.try_into().ok().map(i32::from_le_bytes)
    };
    // A count of bins or channels, which no float and no text is.
    let is_count = |index: usize| word(index).is_some_and(|count| (0..=4096).contains(&count));
    if bytes.len() >= 64 && (0..16).all(is_count) && word(10).is_some_and(|channels| (1..=4).contains(&channels)) {
        return Err(Refused::NotYet("the anisotropic measurements of MIT (Ngan et al. 2005, `.dat`)"));
    }
    let product = (0..3).try_fold(1i64, |product, index| product.checked_mul(i64::from(word(index)?)));
    if product == Some(merl::BINS as i64) || (0..3).all(|index| is_count(index) && word(index) != Some(0)) {
        return Ok(Kind::Merl);
    }
    if bytes.len() == UTIA {
        return Err(Refused::NotYet("UTIA's measured BRDF (`.bin`)"));
    }
    Err(Refused::Binary)
}

fn of_text(text: &str) -> Result<Kind, Refused> {
    let trimmed = text.trim_start_matches('\u{feff}').trim_start();
    let first = trimmed.split_whitespace().next().unwrap_or_default();
    match first {
        "" => return Err(Refused::Empty),
        "analytic" | "bparam" => return Ok(Kind::Explorer),
        _ => {}
    }
    if let Some(refused) = foreign(trimmed) {
        return Err(refused);
    }
    let code = without_comments(text);
    if is_wgsl(&code) {
        return Ok(Kind::Wgsl);
    }
    // Tables and keys stand at the start of lines; assignments of shaders end with a semicolon.
    if is_glsl(&code) {
        return Ok(Kind::Glsl);
    }
    if text.lines().any(is_toml) { Ok(Kind::Stack) } else { Err(Refused::Text) }
}

/// Formats of lighting design, optical design and others, by their first words.
fn foreign(text: &str) -> Option<Refused> {
    let start: String = text.chars().take(4000).collect();
    if text.starts_with('<') {
        let format = if start.contains("<WindowElement") {
            "a window's BSDF in XML (WINDOW, Radiance)"
        } else if start.to_ascii_lowercase().contains("<html") {
            "an HTML page: a download that failed?"
        } else if start.contains("<materialx") {
            "MaterialX: give the shader that it generates"
        } else {
            "XML"
        };
        return Some(Refused::Foreign(format));
    }
    if text.starts_with("IESNA") {
        return Some(Refused::Foreign("a luminaire's photometry (IES LM-63)"));
    }
    if text.starts_with("version https://git-lfs") {
        return Some(Refused::Foreign("a pointer of Git LFS: fetch the file itself"));
    }
    let has = |words: &[&str]| words.iter().all(|word| start.contains(word));
    if has(&["SampleRotation"]) || has(&["ScatterType"]) || has(&["AngleOfIncidence", "SpectralContent"]) {
        return Some(Refused::Foreign("an optical designer's tabular BSDF (Zemax, Radiant)"));
    }
    if has(&["VARS_PER_SAMPLE"]) || has(&["VARS ", "theta_i"]) || has(&["TIS", "theta_s"]) {
        return Some(Refused::Foreign("a table of scatter data (ASTM E1392)"));
    }
    if text.starts_with('{') || text.starts_with("[{") {
        return Some(Refused::Foreign("JSON"));
    }
    // Numbers alone.
    let mut words = text.split_whitespace().take(64).peekable();
    if words.peek().is_some() && words.all(|word| word.parse::<f64>().is_ok()) {
        return Some(Refused::Foreign("a table of numbers"));
    }
    None
}

/// The text with `//` and `/* */` comments as blanks.
fn without_comments(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('/') {
        code.push_str(&rest[..at]);
        rest = &rest[at..];
        if rest.starts_with("//") {
            rest = &rest[rest.find('\n').unwrap_or(rest.len())..];
        } else if rest.starts_with("/*") {
            rest = rest.find("*/").map_or("", |end| &rest[end + 2..]);
            code.push(' ');
        } else {
            code.push('/');
            rest = &rest[1..];
        }
    }
    code.push_str(rest);
    code
}

/// The identifiers of a text, each with the text after it.
fn words(code: &str) -> impl Iterator<Item = (&str, &str)> {
    let mut at = 0;
    core::iter::from_fn(move || {
        let rest = &code[at..];
        let start = at + rest.find(|c: char| c.is_ascii_alphanumeric() || c == '_')?;
        let length = code[start..].find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        at = length.map_or(code.len(), |length| start + length);
        Some((&code[start..at], &code[at..]))
    })
}

/// Whether what follows is a name and then `then`.
fn names(after: &str, then: char) -> bool {
    let after = after.trim_start();
    let name = after.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_');
    name.len() < after.len() && name.trim_start().starts_with(then)
}

/// `fn name(`, `struct`s and constants with types after a colon, imports of WESL.
fn is_wgsl(code: &str) -> bool {
    words(code).any(|(word, after)| match word {
        "fn" => names(after, '(') || names(after, '<'),
        "const" | "let" | "override" | "alias" => names(after, ':'),
        "var" => after.starts_with('<'),
        "import" => after.trim_start().starts_with("package::") || after.trim_start().starts_with("super::"),
        _ => false,
    }) || code.contains("@compute")
        || code.contains("#import ")
}

/// A directive, or a function or global of a GLSL type.
fn is_glsl(code: &str) -> bool {
    let directive = |line: &str| {
        let line = line.trim_start();
        ["#version", "#define", "#include", "#ifdef", "#ifndef", "#extension"].iter().any(|d| line.starts_with(d))
            || line.starts_with("precision ")
    };
    let types =
        ["void", "float", "int", "uint", "bool", "double", "vec2", "vec3", "vec4", "mat2", "mat3", "mat4", "Spectrum"];
    code.lines().any(directive)
        || words(code).any(|(word, after)| {
            (types.contains(&word) && (names(after, '(') || names(after, ';')))
                || (word == "struct" && names(after, '{') && code.contains(';'))
                || (matches!(word, "uniform" | "varying") && after.starts_with([' ', '\t']) && code.contains(';'))
        })
}

/// `[table]`, `[[table]]` or `key = value`.
fn is_toml(line: &str) -> bool {
    let line = line.trim();
    let key = |key: &str| {
        let key = key.trim();
        !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || "_-.\"' ".contains(c))
    };
    if let Some(table) = line.strip_prefix('[') {
        let end = table.trim_start_matches('[').find(']');
        return end.is_some_and(|end| key(table.trim_start_matches('[').get(..end).unwrap_or_default()));
    }
    line.split_once('=').is_some_and(|(name, value)| key(name) && !value.is_empty() && !line.ends_with(';'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_told_by_content() {
        let merl: Vec<u8> = [90, 90, 180].iter().flat_map(|d| i32::to_le_bytes(*d)).collect();
        let wrong: Vec<u8> = [90, 90, 360].iter().flat_map(|d| i32::to_le_bytes(*d)).chain([0; 100]).collect();
        let cases: [(&[u8], Kind); 20] = [
            (b"name = \"x\"\n[[layer]]\ninterface = { dielectric = { n = 1.5 } }\n", Kind::Stack),
            (b"# copper // not GLSL\n[[layer]]\n[layer.interface]\nalpha = 3e-1\n", Kind::Stack),
            (b"[[layer]]", Kind::Stack),
            (b"analytic\n\n# c\n::begin parameters\nfloat n 0 1 1\n", Kind::Explorer),
            (b"  bparam x.brdf\n", Kind::Explorer),
            (&merl, Kind::Merl),
            (&wrong, Kind::Merl),
            (b"fn brdf(l: vec3f, v: vec3f) -> vec3f { return l; }", Kind::Wgsl),
            (b"// float f(\nconst PI: f32 = 3.1;\nfn f<T>() {}", Kind::Wgsl),
            (b"import package::fresnel::schlick;\nfn f(x: f32) -> f32 { return schlick(x); }", Kind::Wgsl),
            (b"#import bevy_pbr::lighting\nfn d(x: f32) -> f32 { return x; }", Kind::Wgsl),
            (b"#define_import_path bevy_pbr::x\nfn d(roughness: f32) -> f32 { return roughness; }", Kind::Wgsl),
            (b"#version 300 es\nprecision highp float;\nfloat D(float x) { return x; }", Kind::Glsl),
            (b"float D_GGX(const in float alpha) {\n  return alpha;\n}", Kind::Glsl),
            (b"/* fn f( */ vec3 BRDF( vec3 L, vec3 V ) { vec3 x = L; return x; }", Kind::Glsl),
            (b"#define saturate(x) clamp(x, 0.0, 1.0)\n", Kind::Glsl),
            (b"struct Material { vec3 color; };\nvec3 f(Material m) { return m.color; }", Kind::Glsl),
            (b"uniform sampler2D lut;\n", Kind::Glsl),
            (b"@compute @workgroup_size(1) fn main() {}", Kind::Wgsl),
            (b"void main() {}", Kind::Glsl),
        ];
        for (bytes, kind) in cases {
            assert_eq!(sniff(bytes), Ok(kind), "{}", String::from_utf8_lossy(bytes));
        }
    }

    #[test]
    fn others_are_refused_by_name() {
        let mut mit: Vec<u8> = [90, 7200, 3, 0].iter().flat_map(|d| i32::to_le_bytes(*d % 4096)).collect();
        mit.extend([0i32, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0, 0].iter().flat_map(|d| d.to_le_bytes()));
        mit.extend([0.25f32; 16].iter().flat_map(|x| x.to_le_bytes()));
        let utia = 0.125f64.to_le_bytes().repeat(3 * 288 * 288);
        let cases: [(&[u8], &str); 16] = [
            (b"", "empty"),
            (b" \n\t", "empty"),
            (b"tensor_file\0\x01\0\x09\0\0\0", "RGL's measured BRDF (a tensor file, `.bsdf`): not supported yet"),
            (&mit, "MIT (Ngan et al. 2005, `.dat`): not supported yet"),
            (&utia, "UTIA's measured BRDF (`.bin`): not supported yet"),
            (b"<?xml version=\"1.0\"?>\n<WindowElement xmlns=\"x\">", "window's BSDF in XML"),
            (b"<brdf/>", "looks like XML"),
            (b"<!DOCTYPE html><html>", "HTML"),
            (b"Source  Measured\nSymmetry  PlaneSymmetrical\nSpectralContent Monochrome\nScatterType BRDF\n", "Zemax"),
            (b"IESNA:LM-63-2002\n", "IES"),
            (b"0.0 1.0 2.0\n3e-1 4 5\n", "table of numbers"),
            (b"{\"a\": 1}", "JSON"),
            (b"\x89PNG\r\n\x1a\n\0\0", "PNG"),
            (b"\x01\x02\xff\xff\0\0\0\0\xff\xff\xff\xff\0", "binary data"),
            (b"Dear all, this is a letter about roughness.", "text without"),
            (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "Git LFS"),
        ];
        for (bytes, wanted) in cases {
            let message = sniff(bytes).unwrap_err().to_string();
            assert!(message.contains(wanted) && !message.contains('\n'), "{message}");
        }
    }

    #[test]
    fn any_bytes_are_something_or_refused() {
        let samples: [&[u8]; 4] = [b"analytic\n::begin", b"fn f(", b"/*/ /**//", "α = [[β]] é//".as_bytes()];
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        for round in 0..4000 {
            let mut bytes = samples[round % 4].to_vec();
            for _ in 0..round % 7 {
                let at = usize::from(next()) % bytes.len();
                bytes[at] = if round % 2 == 0 { next() } else { b"/*[]=\n \0"[usize::from(next() % 8)] };
            }
            if let Err(refused) = sniff(&bytes) {
                assert!(!refused.to_string().contains('\n'));
            }
        }
    }
}
