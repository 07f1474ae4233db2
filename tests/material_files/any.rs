//! Files of fields chosen at random.

use super::{load, second};
use brdf::material::Point;
use brdf::material::description::read_file;

/// Numbers that choose what a file says.
struct Chance(u32, u32);

impl Chance {
    fn below(&mut self, count: u32) -> u32 {
        self.1 += 1;
        brdf::random::random_words([self.0, self.1, 0, 0])[0] % count
    }

    fn one<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[self.below(of.len() as u32) as usize]
    }

    fn number(&mut self) -> &'static str {
        self.one(&["0.5", "0", "1", "0.02", "-0.3", "1e30", "-1e30", "1e-30", "7.5"])
    }

    fn scalar(&mut self, depth: u32) -> String {
        let deep = depth > 2;
        match self.below(if deep { 4 } else { 11 }) {
            0 => self.one(&["0.5", "0.3", "1"]).to_owned(),
            1 => self.one(&["'u'", "'x'", "'occlusion'", "'distance'"]).to_owned(),
            2 => {
                let frequency = self.one(&["0.5", "0", "0.02", "-0.3", "1e4", "-1e4", "1e-30", "7.5"]);
                format!("{{ noise = {{ frequency = {frequency}, octaves = {} }} }}", self.below(12) + 1)
            }
            3 => "{ image = 'a.png', channel = 'g', repeat = [3, 0.5] }".to_owned(),
            4 => format!("{{ sum = [{}, {}] }}", self.scalar(depth + 1), self.scalar(depth + 1)),
            5 => format!("{{ product = [{}, {}] }}", self.scalar(depth + 1), self.number()),
            6 => format!("{{ mix = [{}, 1], by = {} }}", self.scalar(depth + 1), self.scalar(depth + 1)),
            7 => format!("{{ levels = [{}, {}], of = {} }}", self.number(), self.number(), self.scalar(depth + 1)),
            8 => format!("{{ above = {}, softness = 0.1, of = {} }}", self.number(), self.scalar(depth + 1)),
            9 => format!("{{ extent = {}, transition = 0.2, of = {} }}", self.number(), self.scalar(depth + 1)),
            _ => {
                format!("{{ of = {}, scale = {}, offset = {} }}", self.scalar(depth + 1), self.number(), self.number())
            }
        }
    }

    fn colour(&mut self, depth: u32) -> String {
        match self.below(if depth > 2 { 3 } else { 8 }) {
            0 => "0.5".to_owned(),
            1 => "[0.25, 1, 0.75]".to_owned(),
            2 => "{ image = 'a.png' }".to_owned(),
            3 => format!("{{ grey = {} }}", self.scalar(depth + 1)),
            4 => format!("{{ ramp = [0, [0.5, 1, 1], 1], by = {} }}", self.scalar(depth + 1)),
            5 => format!("{{ bands = [0, 0.75, 1], softness = 0.1, by = {} }}", self.scalar(depth + 1)),
            6 => format!("{{ mix = [0, {}], by = {} }}", self.colour(depth + 1), self.scalar(depth + 1)),
            _ => format!("{{ colour = {}, scale = {} }}", self.colour(depth + 1), self.scalar(depth + 1)),
        }
    }

    fn file(&mut self) -> String {
        let (cover, alpha, base) = (self.scalar(0), self.scalar(0), self.colour(0));
        let (sigma, thickness, dim) = (self.colour(0), self.scalar(0), self.colour(0));
        let height = self.scalar(0);
        let medium = format!("medium = {{ sigma = {sigma}, thickness = {thickness} }}");
        let coat = format!("{{ interface = {{ dielectric = {{ n = 1.5 }}, alpha = {alpha} }}, {medium} }}");
        let relief = format!("relief = {{ height = {height}, step = 0.01 }}");
        let base = format!("{{ interface = {{ diffuse = {{ albedo = {base} }} }} }}");
        second(&format!("cover = {cover}\nreflectivity = {dim}\n{relief}\nlayer = [{coat}, {base}]"))
    }
}

/// Files of chosen fields, half of them with a character gone: read, and what they reflect is a number; or refused in one line.
#[test]
fn any_fields_are_read_or_refused() {
    let mut read = 0;
    for index in 0..20_000 {
        let mut chance = Chance(index, 0);
        let mut text = chance.file();
        if index % 2 == 1 {
            text.remove(chance.below(text.len() as u32) as usize);
        }
        match read_file(&text, load) {
            Ok(file) => {
                read += 1;
                let position = brdf::Vector::new(0.3, -0.4, 0.5);
                let [tangent, bitangent] = [brdf::Vector::new(1.0, 0.0, 0.0), brdf::Vector::new(0.0, 1.0, 0.0)];
                let point = Point { uv: [0.3, 0.7], position, tangent, bitangent, ..Point::<f32>::default() };
                let (wi, wo) = (brdf::Vector::new(0.6, 0.0, 0.8), brdf::Vector::new(0.0, -0.28, 0.96));
                let f = file.material.at(&point).reflected(wi, wo);
                assert!(f.iter().all(|x| x.is_finite() && *x >= 0.0), "{text}: {f:?}");
            }
            Err(error) => {
                let line = error.to_string();
                assert!(!line.is_empty() && !line.contains('\n'), "{text:?}: {line:?}");
                let expected = ["is not allowed", "has no slope"].iter().any(|problem| line.contains(problem));
                assert!(index % 2 == 1 || expected, "{text}: {line}");
            }
        }
    }
    assert!(read > 8_000, "{read}");
}
