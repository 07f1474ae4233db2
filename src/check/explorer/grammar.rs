//! The text of a `.brdf` file, section by section.
//!
//! As the tool's own reader has it: the first word of the first line is `analytic`; a line is blank, starts with `#` and
//! is dropped (also inside a shader), opens a section by `::begin NAME`, closes it by `::end NAME`, or belongs to the open
//! section. Lines outside of sections, and sections that are neither `parameters`, `shader` nor `isFunc`, are passed over.
//! What the reader would let pass and then show wrongly is an error here: a number that is none, a section that never ends.

use super::ExplorerError;

/// A slider, a tick box or a colour of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Declared {
    /// The name that the shader uses.
    pub name: String,
    /// What the shader knows it as, and what it starts from.
    pub kind: Kind,
}

/// The type of a parameter with its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// `float name min max default`.
    Float {
        /// The left end of the slider.
        low: f64,
        /// The right end.
        high: f64,
        /// Where it stands.
        default: f64,
    },
    /// `bool name 0|1`.
    Bool(bool),
    /// `color name r g b`.
    Color([f64; 3]),
}

/// What a file says.
#[derive(Clone, Debug, PartialEq)]
pub struct File {
    /// Its parameters, in the order of declaration.
    pub parameters: Vec<Declared>,
    /// The lines of the shader, each at its place in the file: all others are empty.
    pub shader: String,
    /// Whether the file says how to draw directions for it.
    pub samples: bool,
}

/// Words of the language that no parameter can be named.
const RESERVED: [&str; 14] =
    ["BRDF", "main", "float", "int", "uint", "bool", "vec2", "vec3", "vec4", "mat3", "mat4", "void", "if", "return"];

impl File {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// The first line that is against the grammar, with its number.
    pub fn parse(text: &str) -> Result<Self, ExplorerError> {
        let mut lines = text.lines();
        let first = lines.next().unwrap_or_default();
        match first.split_whitespace().next() {
            Some("analytic") => {}
            Some("bparam") => {
                let message = "`bparam` sets the parameters of another file, which it names: give that file";
                return Err(ExplorerError::at(1, message));
            }
            _ => return Err(ExplorerError::at(1, "the first word is not `analytic`: no BRDF Explorer file")),
        }
        let mut file = File { parameters: Vec::new(), shader: "\n".to_owned(), samples: false };
        // The open section and the line that opened it.
        let mut open: Option<(&str, usize)> = None;
        let mut has_shader = false;
        for (index, line) in lines.enumerate() {
            let number = index + 2;
            let mut kept = "";
            let mut words = line.split_whitespace();
            match words.next() {
                None => {}
                Some(word) if word.starts_with('#') => {}
                Some("::begin") => {
                    let name = words.next().ok_or_else(|| ExplorerError::at(number, "`::begin` of what?"))?;
                    if let Some((before, since)) = open {
                        let message = format!("`::begin {name}` inside `{before}`, which line {since} opened");
                        return Err(ExplorerError::at(number, message));
                    }
                    open = Some((name, number));
                    has_shader |= name == "shader";
                }
                Some("::end") => {
                    let name = words.next().unwrap_or_default();
                    match open {
                        Some((before, _)) if before == name => open = None,
                        Some((before, since)) => {
                            let message = format!("`::end {name}`, but line {since} opened `{before}`");
                            return Err(ExplorerError::at(number, message));
                        }
                        None => return Err(ExplorerError::at(number, format!("`::end {name}` of nothing"))),
                    }
                }
                Some(word) => match open {
                    Some(("parameters", _)) => {
                        let declared = declaration(word, &mut words).map_err(|m| ExplorerError::at(number, m))?;
                        if file.parameters.iter().any(|other| other.name == declared.name) {
                            let message = format!("a second parameter `{}`", declared.name);
                            return Err(ExplorerError::at(number, message));
                        }
                        file.parameters.push(declared);
                    }
                    Some(("shader", _)) => kept = line,
                    Some(("isFunc", _)) => file.samples = true,
                    _ => {}
                },
            }
            file.shader.push_str(kept);
            file.shader.push('\n');
        }
        if let Some((name, since)) = open {
            return Err(ExplorerError::at(since, format!("`::begin {name}` without `::end {name}`")));
        }
        if !has_shader {
            return Err(ExplorerError::plain("no `::begin shader` section: nothing to evaluate"));
        }
        Ok(file)
    }
}

/// A line of the section `parameters`. Words after its values are passed over.
fn declaration<'a>(ty: &str, words: &mut impl Iterator<Item = &'a str>) -> Result<Declared, String> {
    let wanted = match ty {
        "float" => "float NAME MIN MAX DEFAULT",
        "bool" => "bool NAME 0|1",
        "color" => "color NAME R G B",
        _ => return Err(format!("`{ty}` is no type of parameter: float, bool or color")),
    };
    let name = words.next().ok_or_else(|| format!("not `{wanted}`"))?;
    let starts = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    let inside = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !starts || !inside || name.starts_with("gl_") || name.contains("__") || RESERVED.contains(&name) {
        return Err(format!("`{name}` is no name for a parameter"));
    }
    let mut number = || -> Result<f64, String> {
        let word = words.next().ok_or_else(|| format!("`{name}` has too few values: `{wanted}`"))?;
        // What C++ reads: 1., .5 and 1.0f are numbers.
        let value = word.strip_suffix('f').unwrap_or(word).parse::<f64>().ok();
        // The tool holds values in single precision.
        value.filter(|v| v.abs() <= f64::from(f32::MAX)).ok_or_else(|| format!("`{word}` is no number: `{wanted}`"))
    };
    let kind = match ty {
        "float" => {
            let (low, high, default) = (number()?, number()?, number()?);
            if low > high {
                return Err(format!("`{name}` has its least value {low} above its largest {high}"));
            }
            Kind::Float { low, high, default }
        }
        "color" => Kind::Color([number()?, number()?, number()?]),
        _ => match words.next() {
            Some("0") => Kind::Bool(false),
            Some("1") => Kind::Bool(true),
            _ => return Err(format!("`{name}` is neither 0 nor 1: `{wanted}`")),
        },
    };
    Ok(Declared { name: name.to_owned(), kind })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "analytic with words\n# a comment\n\n::begin parameters\nfloat n 1 1000 100\n  bool on 1\n\
        # float gone 0 1 0\ncolor c .1 1. 0.5\n::end parameters\nstray\n::begin notes\nx\n::end notes\n::begin shader\n\
        #define GONE\nvec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y)\n   # gone too\n{ return c; }\n::end shader\n\
        ::begin isFunc\nvec3 sample;\n::end isFunc\n";

    #[test]
    fn sections_are_told_apart_and_lines_keep_their_numbers() {
        let file = File::parse(FILE).unwrap();
        let names: Vec<_> = file.parameters.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["n", "on", "c"]);
        assert_eq!(file.parameters[0].kind, Kind::Float { low: 1.0, high: 1000.0, default: 100.0 });
        assert_eq!(file.parameters[1].kind, Kind::Bool(true));
        assert_eq!(file.parameters[2].kind, Kind::Color([0.1, 1.0, 0.5]));
        assert!(file.samples);
        let kept: Vec<_> = file.shader.lines().enumerate().filter(|(_, line)| !line.is_empty()).collect();
        let brdf = "vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y)";
        assert_eq!(kept, [(15, brdf), (17, "{ return c; }")]);
        assert_eq!(File::parse(&FILE.replace('\n', "\r\n")).unwrap(), file);
    }

    #[test]
    fn errors_name_the_line() {
        let cases = [
            ("", "line 1: the first word is not `analytic`"),
            ("<?xml version", "line 1: the first word is not `analytic`"),
            ("bparam a.brdf\n", "line 1: `bparam` sets the parameters of another file"),
            ("analytic\n\n::begin\n", "line 3: `::begin` of what?"),
            (
                "analytic\n::begin shader\n::begin parameters\n",
                "line 3: `::begin parameters` inside `shader`, which line 2",
            ),
            ("analytic\n::begin shader\n::end parameters\n", "line 3: `::end parameters`, but line 2 opened `shader`"),
            ("analytic\n::end shader\n", "line 2: `::end shader` of nothing"),
            ("analytic\n::begin shader\nfloat x;\n", "line 2: `::begin shader` without `::end shader`"),
            ("analytic\n::begin parameters\n::end parameters\n", "no `::begin shader` section"),
            ("analytic\n::begin parameters\nint n 1 2 3\n", "line 3: `int` is no type of parameter"),
            (
                "analytic\n::begin parameters\nfloat n 1 2\n",
                "line 3: `n` has too few values: `float NAME MIN MAX DEFAULT`",
            ),
            ("analytic\n::begin parameters\nfloat n 1 x 2\n", "line 3: `x` is no number"),
            ("analytic\n::begin parameters\nfloat n 0 nan 1\n", "line 3: `nan` is no number"),
            ("analytic\n::begin parameters\nfloat n 0 inf 1\n", "line 3: `inf` is no number"),
            ("analytic\n::begin parameters\nfloat n 2 1 1\n", "line 3: `n` has its least value 2 above its largest 1"),
            ("analytic\n::begin parameters\nfloat n;x 0 1 1\n", "line 3: `n;x` is no name"),
            ("analytic\n::begin parameters\nbool b 2\n", "line 3: `b` is neither 0 nor 1"),
            ("analytic\n::begin parameters\nbool b\n", "line 3: `b` is neither 0 nor 1"),
            ("analytic\n::begin parameters\nfloat b 0 1 0\nbool b 1\n", "line 4: a second parameter `b`"),
        ];
        for (text, wanted) in cases {
            let error = File::parse(text).unwrap_err().to_string();
            assert!(error.starts_with(wanted), "{text:?}: {error}");
        }
    }
}
