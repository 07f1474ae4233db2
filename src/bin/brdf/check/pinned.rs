//! `--param` and `--range` for families that do not read them themselves.

use brdf::check::{Family, Parameter, Scale, Subject};

/// A family some of whose parameters are set, and some ranges changed.
pub(super) struct Pinned {
    family: Box<dyn Family + Send>,
    /// The parameters that are still open.
    open: Vec<Parameter>,
    /// For each parameter of the family: its value, or which of the open ones it is.
    slots: Vec<Result<f64, usize>>,
}

/// Sets parameters (`NAME=VALUE`) and changes ranges (`NAME=LO..HI`, with `:log` for a logarithmic one).
///
/// # Errors
///
/// A text that is neither, with what is; a name that the family lacks, with those it has; a value outside of its range.
pub(super) fn pin(family: Box<dyn Family + Send>, values: &[String], ranges: &[String]) -> Result<Pinned, String> {
    let mut parameters = family.parameters().to_vec();
    let known: Vec<String> = parameters.iter().map(|parameter| parameter.name.clone()).collect();
    let find = |name: &str, option: &str| {
        let names = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        let missing = || format!("{option} {name}: no such parameter; there are {names}");
        known.iter().position(|known| known == name).ok_or_else(missing)
    };
    for range in ranges {
        let wrong = || format!("--range {range}: want NAME=LO..HI or NAME=LO..HI:log, with LO < HI");
        let (name, limits) = range.split_once('=').ok_or_else(wrong)?;
        let (limits, logarithmic) = limits.strip_suffix(":log").map_or((limits, false), |limits| (limits, true));
        let (low, high) = limits.split_once("..").ok_or_else(wrong)?;
        let (low, high) = (number(low).ok_or_else(wrong)?, number(high).ok_or_else(wrong)?);
        if low >= high || (logarithmic && low <= 0.0) {
            return Err(wrong());
        }
        let index = find(name, "--range")?;
        let parameter = &mut parameters[index];
        let scale = if logarithmic { Scale::Logarithmic } else { Scale::Linear };
        *parameter = Parameter { low, high, default: parameter.default.clamp(low, high), scale, ..parameter.clone() };
    }
    let mut pinned: Vec<Option<f64>> = vec![None; parameters.len()];
    for value in values {
        let wrong = || format!("--param {value}: want NAME=VALUE");
        let (name, text) = value.split_once('=').ok_or_else(wrong)?;
        let x = number(text).ok_or_else(wrong)?;
        let index = find(name, "--param")?;
        let Parameter { low, high, .. } = parameters[index];
        if !(low..=high).contains(&x) {
            return Err(format!("--param {value}: {name} lies in {low}..{high}; --range {name}=LO..HI changes that"));
        }
        pinned[index] = Some(x);
    }
    let mut open = Vec::new();
    let slots = pinned
        .into_iter()
        .zip(parameters)
        .map(|(value, parameter)| {
            value.ok_or_else(|| {
                open.push(parameter);
                open.len() - 1
            })
        })
        .collect();
    Ok(Pinned { family, open, slots })
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|x: &f64| x.is_finite())
}

impl Pinned {
    /// The values of all parameters, of those of the open ones.
    pub(super) fn whole(&self, values: &[f64]) -> Vec<f64> {
        let value = |slot: &Result<f64, usize>| match *slot {
            Ok(value) => value,
            Err(index) => values.get(index).copied().unwrap_or_else(|| self.open[index].default),
        };
        self.slots.iter().map(value).collect()
    }
}

impl Family for Pinned {
    fn name(&self) -> String {
        self.family.name()
    }

    fn parameters(&self) -> &[Parameter] {
        &self.open
    }

    fn subject(&self, values: &[f64]) -> Box<dyn Subject + '_> {
        self.family.subject(&self.whole(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdf::Vector;

    struct Three(Vec<Parameter>);
    struct Member(Vec<f64>);

    impl Family for Three {
        fn name(&self) -> String {
            "three".into()
        }
        fn parameters(&self) -> &[Parameter] {
            &self.0
        }
        fn subject(&self, values: &[f64]) -> Box<dyn Subject + '_> {
            Box::new(Member(values.to_vec()))
        }
    }

    impl Subject for Member {
        fn name(&self) -> String {
            "member".into()
        }
        fn channels(&self) -> usize {
            3
        }
        fn evaluate(&self, _: Vector<f64>, _: Vector<f64>, f: &mut [f64]) {
            f.copy_from_slice(&self.0);
        }
    }

    fn three() -> Box<dyn Family + Send> {
        let parameter =
            |name: &str| Parameter { name: name.into(), low: 0.0, high: 1.0, default: 0.5, scale: Scale::Linear };
        Box::new(Three(["a", "b", "c"].map(parameter).into()))
    }

    #[test]
    fn set_parameters_are_not_searched() {
        let family = pin(three(), &["b=0.25".into()], &["c=0.75..8:log".into()]).unwrap_or_else(|e| panic!("{e}"));
        let names: Vec<&str> = family.parameters().iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["a", "c"]);
        let c = &family.parameters()[1];
        assert_eq!((c.low, c.high, c.default, c.scale), (0.75, 8.0, 0.75, Scale::Logarithmic));
        let mut f = [0.0; 3];
        let up = Vector::new(0.0, 0.0, 1.0);
        family.subject(&[0.1, 3.0]).evaluate(up, up, &mut f);
        assert_eq!(f, [0.1, 0.25, 3.0]);
    }

    #[test]
    fn wrong_words_are_named() {
        for (value, range, says) in [
            ("d=1", "", "there are a, b, c"),
            ("a=2", "", "lies in 0..1"),
            ("a", "", "want NAME=VALUE"),
            ("a=x", "", "want NAME=VALUE"),
            ("", "a=1..0", "LO < HI"),
            ("", "a=0..1:log", "LO < HI"),
            ("", "z=0..1", "there are a, b, c"),
        ] {
            let list = |text: &str| if text.is_empty() { Vec::new() } else { vec![text.to_owned()] };
            let error = pin(three(), &list(value), &list(range)).err().expect("an error");
            assert!(error.contains(says), "{value} {range}: {error}");
        }
    }
}
