//! Reports read back from JSON, with errors that say which field is wrong.

use super::figures::{Figures, Grid, Series};
use super::json::VERSION;
use super::{Entry, Outcome, OutputError, Run, Shard};
use crate::check::energy::Albedo;
use crate::check::family::{Parameter, Scale};
use crate::check::report::{Check, Coverage, Finding, Place, Report, Values};
use crate::check::subject::Fixed;
use crate::check::verdict::Verdict;
use crate::frame::Vector;
use serde_json::Value;

type Result<T> = core::result::Result<T, OutputError>;

impl Run {
    /// Reads what [`Run::to_json`] wrote.
    ///
    /// # Errors
    ///
    /// One line with the path of the field that is missing or of the wrong kind; or with the line and column at which the
    /// text is no JSON; or with the version, if it is another one than [`VERSION`].
    pub fn from_json(text: &str) -> Result<Run> {
        let value: Value = serde_json::from_str(text)
            .map_err(|error| OutputError(format!("no JSON report of brdf check: {error}")))?;
        let root = Field { value: &value, path: String::new() };
        if value.get("schema").and_then(Value::as_str) != Some("brdf-check") {
            return Err(OutputError("no report of brdf check: `schema` is not \"brdf-check\"".into()));
        }
        let version = root.get("version")?.whole()?;
        if version as u64 != VERSION {
            let made = format!("the report has version {version} of the schema, and this program reads {VERSION}");
            return Err(OutputError(format!("{made}: make it again with this program")));
        }
        let shard = |shard: Field<'_>| {
            Ok(Shard { number: shard.get("number")?.whole()?.max(1), of: shard.get("of")?.whole()?.max(1) })
        };
        Ok(Run {
            tool: root.get("tool")?.text()?,
            twins: root.get("twins")?.text()?,
            total: root.get("total")?.whole()?,
            shard: root.optional("shard").map(shard).transpose()?,
            entries: root.get("reports")?.each(entry)?,
        })
    }
}

/// A value and how it is reached from the root.
struct Field<'a> {
    value: &'a Value,
    path: String,
}

impl<'a> Field<'a> {
    fn wrong(&self, wanted: &str) -> OutputError {
        OutputError(format!("{}: want {wanted}, found {}", self.path, excerpt(self.value)))
    }

    fn inside(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    fn get(&self, key: &str) -> Result<Field<'a>> {
        match self.value.get(key) {
            Some(value) => Ok(Field { value, path: self.inside(key) }),
            None => Err(OutputError(format!("{}: missing", self.inside(key)))),
        }
    }

    /// The field, unless it is missing or null.
    fn optional(&self, key: &str) -> Option<Field<'a>> {
        self.value.get(key).filter(|value| !value.is_null()).map(|value| Field { value, path: self.inside(key) })
    }

    fn each<T>(&self, read: impl Fn(Field<'a>) -> Result<T>) -> Result<Vec<T>> {
        let list = self.value.as_array().ok_or_else(|| self.wrong("a list"))?;
        list.iter().enumerate().map(|(i, value)| read(Field { value, path: format!("{}[{i}]", self.path) })).collect()
    }

    fn text(&self) -> Result<String> {
        self.value.as_str().map(str::to_owned).ok_or_else(|| self.wrong("a string"))
    }

    fn flag(&self) -> Result<bool> {
        self.value.as_bool().ok_or_else(|| self.wrong("true or false"))
    }

    fn whole(&self) -> Result<usize> {
        let whole = self.value.as_u64().and_then(|x| usize::try_from(x).ok());
        whole.ok_or_else(|| self.wrong("a whole number, not negative"))
    }

    fn number(&self) -> Result<f64> {
        match self.value {
            Value::String(name) if name == "NaN" => Ok(f64::NAN),
            Value::String(name) if name == "Infinity" => Ok(f64::INFINITY),
            Value::String(name) if name == "-Infinity" => Ok(f64::NEG_INFINITY),
            value => value.as_f64().ok_or_else(|| self.wrong("a number, \"NaN\", \"Infinity\" or \"-Infinity\"")),
        }
    }

    fn numbers(&self) -> Result<Vec<f64>> {
        self.each(|field| field.number())
    }

    /// Numbers in one string, apart by spaces.
    fn row(&self) -> Result<Vec<f64>> {
        let text = self.value.as_str().ok_or_else(|| self.wrong("a string of numbers"))?;
        text.split_ascii_whitespace().map(|word| word.parse().map_err(|_| self.wrong("a string of numbers"))).collect()
    }

    fn vector(&self) -> Result<Vector<f64>> {
        match self.numbers()?[..] {
            [x, y, z] => Ok(Vector::new(x, y, z)),
            _ => Err(self.wrong("three numbers")),
        }
    }

    fn fixed(&self) -> Result<Fixed> {
        let name = self.value.as_str();
        let fixed = Fixed::BOTH.into_iter().find(|fixed| Some(fixed.name()) == name);
        fixed.ok_or_else(|| self.wrong("\"view\" or \"light\""))
    }
}

/// The start of a value, for a message.
fn excerpt(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", text.get(..end).unwrap_or_default()),
        None => text,
    }
}

fn entry(field: Field<'_>) -> Result<Entry> {
    let outcome = match field.optional("reason") {
        Some(reason) => Outcome::Refused { reason: reason.text()?, accepted: field.get("accepted")?.flag()? },
        None => Outcome::Judged {
            report: Box::new(report(&field)?),
            figures: field.optional("figures").map(drawing).transpose()?.map(Box::new),
        },
    };
    Ok(Entry {
        index: field.get("index")?.whole()?,
        source: field.get("source")?.text()?,
        kind: field.get("kind")?.text()?,
        outcome,
    })
}

fn report(field: &Field<'_>) -> Result<Report> {
    Ok(Report {
        subject: field.get("subject")?.text()?,
        channel_names: field.get("channels")?.each(|name| name.text())?,
        findings: field.get("findings")?.each(finding)?,
        albedos: field.get("albedos")?.each(albedo)?,
        coverage: coverage(&field.get("coverage")?)?,
        notes: field.get("notes")?.each(|note| note.text())?,
    })
}

fn verdict(field: &Field<'_>) -> Result<Verdict> {
    let name = field.value.as_str();
    let all = [Verdict::Pass, Verdict::Inconclusive, Verdict::Fail];
    let found = all.into_iter().find(|verdict| Some(verdict.name()) == name);
    found.ok_or_else(|| field.wrong("\"PASS\", \"INCONCLUSIVE\" or \"FAIL\""))
}

fn place(field: &Field<'_>) -> Result<Place> {
    if field.value.get("wi").is_some() {
        return Ok(Place::Pair { wi: field.get("wi")?.vector()?, wo: field.get("wo")?.vector()? });
    }
    Ok(Place::Marginal {
        theta: field.get("theta")?.number()?,
        phi: field.get("phi")?.number()?,
        fixed: field.get("fixed")?.fixed()?,
    })
}

fn parameter(field: Field<'_>) -> Result<(String, f64)> {
    Ok((field.get("name")?.text()?, field.get("value")?.number()?))
}

fn finding(field: Field<'_>) -> Result<Finding> {
    let check = field.get("check")?;
    let named = Check::ALL.into_iter().find(|one| Some(one.name()) == check.value.as_str());
    let values = |values: Field<'_>| {
        let [double, single, gpu] = ["f64", "f32", "gpu"].map(|key| values.get(key).and_then(|field| field.numbers()));
        Ok(Values { double: double?, single: single?, gpu: gpu? })
    };
    let channel = |channel: Field<'_>| Ok((channel.get("index")?.whole()?, channel.get("name")?.text()?));
    Ok(Finding {
        check: named.ok_or_else(|| check.wrong("the name of a check"))?,
        single: field.get("precision")?.text()? == "f32",
        verdict: verdict(&field.get("verdict")?)?,
        binding: field.get("binding")?.flag()?,
        accepted: field.get("accepted")?.flag()?,
        value: field.get("value")?.number()?,
        error: field.get("error")?.number()?,
        limit: field.get("limit")?.number()?,
        place: field.optional("place").map_or(Ok(Place::Everywhere), |field| place(&field))?,
        channel: field.optional("channel").map(channel).transpose()?,
        note: field.get("note")?.text()?,
        parameters: field.get("parameters")?.each(parameter)?,
        values: field.optional("values").map(values).transpose()?,
        cause: field.get("cause")?.text()?,
        again: field.get("again")?.text()?,
    })
}

fn albedo(field: Field<'_>) -> Result<Albedo> {
    Ok(Albedo {
        theta: field.get("theta")?.number()?,
        phi: field.get("phi")?.number()?,
        fixed: field.get("fixed")?.fixed()?,
        value: field.get("value")?.numbers()?,
        error: field.get("error")?.numbers()?,
        cross_check: field.get("cross_check")?.numbers()?,
        standard_error: field.get("standard_error")?.numbers()?,
        agrees: field.get("agrees")?.flag()?,
        non_finite: field.get("non_finite")?.whole()?,
        evaluations: field.get("evaluations")?.whole()?,
    })
}

fn coverage(field: &Field<'_>) -> Result<Coverage> {
    let seed = field.get("seed")?;
    Ok(Coverage {
        seed: u32::try_from(seed.whole()?).map_err(|_| seed.wrong("a seed below 2³²"))?,
        budget: field.get("budget")?.whole()?,
        evaluations: field.get("evaluations")?.whole()?,
        integrals: field.get("integrals")?.whole()?,
        pairs: field.get("pairs")?.whole()?,
        restarts: field.get("restarts")?.whole()?,
        anisotropic: field.get("anisotropic")?.flag()?,
        parameters: field.get("parameters")?.each(range)?,
        members: match field.get("members")?.each(|count| count.whole())?[..] {
            [seen, checked] => [seen, checked],
            _ => return Err(field.get("members")?.wrong("two whole numbers")),
        },
    })
}

fn range(field: Field<'_>) -> Result<Parameter> {
    let scale = field.get("scale")?;
    let named = Scale::ALL.into_iter().find(|one| Some(one.name()) == scale.value.as_str());
    Ok(Parameter {
        name: field.get("name")?.text()?,
        low: field.get("low")?.number()?,
        high: field.get("high")?.number()?,
        default: field.get("default")?.number()?,
        scale: named.ok_or_else(|| scale.wrong("\"linear\", \"logarithmic\" or \"switch\""))?,
    })
}

fn drawing(field: Field<'_>) -> Result<Figures> {
    let sweep = |sweep: Field<'_>| Ok((sweep.get("parameter")?.text()?, map(&sweep.get("map")?)?));
    Ok(Figures {
        parameters: field.get("parameters")?.each(parameter)?,
        albedo: field.get("albedo")?.each(series)?,
        lobes: field.get("lobes")?.each(series)?,
        reciprocity: map(&field.get("reciprocity")?)?,
        validity: map(&field.get("validity")?)?,
        precision: field.get("precision")?.each(series)?,
        sweep: field.optional("sweep").map(sweep).transpose()?,
    })
}

fn map(field: &Field<'_>) -> Result<Grid> {
    let grid = Grid {
        x: field.get("x")?.row()?,
        y: field.get("y")?.row()?,
        values: field.get("rows")?.each(|row| row.row())?.concat(),
    };
    if grid.values.len() != grid.x.len() * grid.y.len() {
        return Err(field.wrong("as many numbers as x has times y"));
    }
    Ok(grid)
}

fn series(field: Field<'_>) -> Result<Series> {
    let series = Series {
        name: field.get("name")?.text()?,
        x: field.get("x")?.row()?,
        y: field.get("y")?.row()?,
        error: field.get("error")?.row()?,
    };
    if series.x.len() != series.y.len() || !(series.error.is_empty() || series.error.len() == series.x.len()) {
        return Err(field.wrong("x, y and error of one length"));
    }
    Ok(series)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{report, text_of};
    use super::*;

    fn run() -> Run {
        let figures = Figures {
            parameters: vec![("roughness".into(), 0.3)],
            albedo: vec![Series {
                name: "view".into(),
                x: vec![0.0, 1.0],
                y: vec![1.0, f64::NAN],
                error: vec![0.1, 0.2],
            }],
            reciprocity: Grid { x: vec![1.0], y: vec![2.0, 3.0], values: vec![f64::NEG_INFINITY, 0.1] },
            ..Figures::default()
        };
        let mut first = Entry::judged(0, "a.wgsl", "WGSL", report("a", Verdict::Fail));
        if let Outcome::Judged { figures: slot, .. } = &mut first.outcome {
            *slot = Some(Box::new(figures));
        }
        let entries = vec![first, Entry::refused(3, "dir/b.brdf", "BRDF Explorer", "torn at byte 7")];
        Run { total: 7, shard: Some(Shard { number: 1, of: 3 }), entries, ..Run::new() }
    }

    #[test]
    fn what_is_written_is_read_back() {
        let run = run();
        let text = run.to_json();
        let again = Run::from_json(&text).expect("our own JSON");
        assert_eq!(text_of(&again), text_of(&run));
        assert_eq!(again.to_json(), text);
    }

    #[test]
    fn every_field_is_needed_and_named_when_it_is_missing() {
        let whole: Value = serde_json::from_str(&run().to_json()).expect("JSON");
        // What is derived on writing, and what may be null.
        let free =
            ["verdict", "exit_code", "line", "shard", "place", "channel", "values", "figures", "sweep", "reason"];
        let mut tried = 0;
        for pointer in [
            "",
            "/shard",
            "/reports/0",
            "/reports/0/findings/0",
            "/reports/0/albedos/0",
            "/reports/0/coverage",
            "/reports/0/coverage/parameters/0",
            "/reports/0/findings/0/place",
            "/reports/0/findings/1/place",
            "/reports/0/findings/1/values",
            "/reports/0/figures",
            "/reports/0/figures/albedo/0",
            "/reports/0/figures/reciprocity",
            "/reports/1",
        ] {
            let keys: Vec<String> =
                whole.pointer(pointer).and_then(Value::as_object).expect(pointer).keys().cloned().collect();
            for key in keys {
                let finding = pointer.ends_with("findings/0");
                if free.contains(&key.as_str()) && !(finding && key == "verdict") {
                    continue;
                }
                // A refused subject has no report; the place of a pair is known by its wi.
                if (pointer == "/reports/1" && key == "subject") || (pointer.ends_with("1/place") && key == "wi") {
                    continue;
                }
                let mut torn = whole.clone();
                torn.pointer_mut(pointer).and_then(Value::as_object_mut).expect(pointer).remove(&key);
                let error = Run::from_json(&torn.to_string()).expect_err(&format!("{pointer}/{key}")).to_string();
                assert!(error.contains(&key) && !error.contains('\n'), "{pointer}/{key}: {error}");
                tried += 1;
            }
        }
        assert!(tried > 50, "{tried}");
    }

    #[test]
    fn foreign_json_is_refused() {
        for (text, says) in [
            ("", "no JSON"),
            ("[1, 2", "line 1"),
            ("{}", "schema"),
            ("{\"schema\": \"brdf-check\", \"version\": 1}", "version 1"),
            ("{\"schema\": \"brdf-check\", \"version\": 2}", "tool"),
        ] {
            let error = Run::from_json(text).expect_err(text).to_string();
            assert!(error.contains(says), "{text}: {error}");
        }
        let deep = "[".repeat(100_000);
        assert!(Run::from_json(&deep).is_err());
    }
}
