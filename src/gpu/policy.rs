//! Whether tests and commands may, must or must not use an adapter: the variable `BRDF_GPU`.

/// What the environment asks of the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// `require`: no adapter is a failure.
    Require,
    /// `auto`, and the default: what needs an adapter is skipped where there is none, and says so.
    Auto,
    /// `off`: adapters are left alone, and what needs one says that it was skipped.
    Off,
}

impl Policy {
    /// The policy that a value of the variable means; `None` is an unset variable.
    ///
    /// A value that is none of the three means [`Policy::Require`], so that a misspelling never skips a test.
    pub fn parse(value: Option<&str>) -> Self {
        match value.map(str::trim) {
            None | Some("" | "auto") => Policy::Auto,
            Some("off") => Policy::Off,
            Some(_) => Policy::Require,
        }
    }
}

/// The policy in the environment variable `BRDF_GPU`.
pub fn policy() -> Policy {
    // A value that is not Unicode is a misspelling.
    let value = std::env::var_os("BRDF_GPU").map(|value| value.to_string_lossy().into_owned());
    Policy::parse(value.as_deref())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspellings_require() {
        assert_eq!(Policy::parse(None), Policy::Auto);
        assert_eq!(Policy::parse(Some("")), Policy::Auto);
        assert_eq!(Policy::parse(Some("auto")), Policy::Auto);
        assert_eq!(Policy::parse(Some("off")), Policy::Off);
        assert_eq!(Policy::parse(Some("require")), Policy::Require);
        assert_eq!(Policy::parse(Some("requrie")), Policy::Require);
    }
}
