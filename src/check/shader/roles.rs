//! What a parameter stands for, by the names that renderers give: directions, cosines, materials.

use crate::check::family::Scale;
use core::fmt;

/// A direction of the local frame, in which the normal is z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Wi,
    Wo,
    Normal,
    Half,
    Tangent,
    Bitangent,
}

/// A part of the geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// A direction, or the one opposite to it.
    Along(Direction, bool),
    /// The cosine between two.
    Cosine(Direction, Direction),
}

/// What `--map` takes.
pub(super) const ROLES: &str = "wi, wo, n, h, t, b (with - the opposite one), n_dot_l, n_dot_v, n_dot_h, l_dot_h, \
                                v_dot_h, l_dot_v, t_dot_l, …, b_dot_h";

impl Role {
    /// Reads a role of `--map`.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim().to_ascii_lowercase();
        let (name, negated) = text.strip_prefix('-').map_or((text.as_str(), false), |name| (name, true));
        if let Some(direction) = named(name) {
            return Ok(Role::Along(direction, negated));
        }
        let pair = name.split_once("_dot_").and_then(|(a, b)| Some((named(a)?, named(b)?)));
        match pair {
            Some((a, b)) if !negated => Ok(Role::Cosine(a, b)),
            _ => Err(format!("`{text}` is none of {ROLES}")),
        }
    }

    /// The components that a parameter of this role has.
    pub(super) fn size(self) -> usize {
        match self {
            Role::Along(..) => 3,
            Role::Cosine(..) => 1,
        }
    }
}

fn named(name: &str) -> Option<Direction> {
    Some(match name {
        "wi" | "l" => Direction::Wi,
        "wo" | "v" => Direction::Wo,
        "n" => Direction::Normal,
        "h" => Direction::Half,
        "t" | "x" => Direction::Tangent,
        "b" | "y" => Direction::Bitangent,
        _ => return None,
    })
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Direction::Wi => "wi",
            Direction::Wo => "wo",
            Direction::Normal => "n",
            Direction::Half => "h",
            Direction::Tangent => "t",
            Direction::Bitangent => "b",
        })
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Role::Along(direction, true) => write!(f, "-{direction}"),
            Role::Along(direction, false) => write!(f, "{direction}"),
            Role::Cosine(a, b) => write!(f, "{a}·{b}"),
        }
    }
}

/// A name without case, underscores and what says nothing: in which space, that it is clamped.
fn plain(name: &str) -> String {
    let mut name: String = name.chars().filter(|c| *c != '_').flat_map(char::to_lowercase).collect();
    for noise in ["clamped", "saturated", "abs", "sat", "pos", "safe"] {
        let stripped = name.strip_prefix(noise).or_else(|| name.strip_suffix(noise)).filter(|rest| rest.len() > 1);
        if let Some(rest) = stripped.map(str::to_owned) {
            name = rest;
        }
    }
    name
}

/// The role of a name, for a parameter of so many components.
pub(super) fn role(name: &str, size: usize) -> Option<Role> {
    let name = plain(name);
    match size {
        1 => cosine(&name),
        3 => direction(&name).map(|direction| Role::Along(direction, false)),
        _ => None,
    }
}

fn cosine(name: &str) -> Option<Role> {
    let angle = ["costheta", "costh", "cos", "mu"].into_iter().find_map(|start| name.strip_prefix(start));
    let with_normal = match angle {
        Some("i" | "in" | "l" | "light" | "0") => Some(Direction::Wi),
        Some("o" | "out" | "v" | "view" | "r") => Some(Direction::Wo),
        Some("h" | "m" | "half") => Some(Direction::Half),
        _ => None,
    };
    if let Some(direction) = with_normal {
        return Some(Role::Cosine(Direction::Normal, direction));
    }
    if angle == Some("d") {
        return Some(Role::Cosine(Direction::Wi, Direction::Half));
    }
    let name = name.strip_prefix("cos").unwrap_or(name);
    let name = name.strip_prefix("dot").unwrap_or(name);
    let letters: Vec<char> = match name.chars().collect::<Vec<_>>().as_slice() {
        // Without a dot: NL, dotTH, and nothing that is a word or an index.
        [a, b] => {
            let (all, some) =
                ([a, b].iter().all(|c| "lvnhtbxy".contains(**c)), [a, b].iter().any(|c| "lvnh".contains(**c)));
            if !(all && some) {
                return None;
            }
            vec![*a, *b]
        }
        // NoL; `o` between two letters is a dot.
        [a, 'o', b] => vec![*a, *b],
        _ => {
            let (a, b) = name.split_once("dot")?;
            return Some(Role::Cosine(of_word(a)?, of_word(b)?));
        }
    };
    let directions: Vec<Direction> = letters.iter().filter_map(|letter| of_word(&letter.to_string())).collect();
    match directions.as_slice() {
        [a, b] if a != b => Some(Role::Cosine(*a, *b)),
        _ => None,
    }
}

fn of_word(word: &str) -> Option<Direction> {
    match word {
        "l" | "i" | "wi" | "light" | "lightdir" => Some(Direction::Wi),
        "v" | "o" | "e" | "wo" | "view" | "viewdir" | "eye" => Some(Direction::Wo),
        "n" | "normal" => Some(Direction::Normal),
        "h" | "wh" | "half" | "m" => Some(Direction::Half),
        "t" | "x" | "tangent" => Some(Direction::Tangent),
        "b" | "y" | "bitangent" | "binormal" => Some(Direction::Bitangent),
        _ => None,
    }
}

fn direction(name: &str) -> Option<Direction> {
    let has = |parts: &[&str]| parts.iter().any(|part| name.contains(part));
    if has(&["color", "colour", "position", "intensity", "radiance", "power", "scale", "tint", "attenuation"]) {
        return None;
    }
    match name {
        "l" | "wi" | "i" | "li" | "ldir" | "toli" | "omegai" | "dirin" | "win" | "incoming" | "incident" | "indir" => {
            return Some(Direction::Wi);
        }
        "v" | "wo" | "o" | "e" | "vdir" | "omegao" | "dirout" | "wout" | "outgoing" | "outdir" => {
            return Some(Direction::Wo);
        }
        "n" | "nrm" | "nor" | "norm" | "ng" | "ns" => return Some(Direction::Normal),
        "h" | "wh" | "m" | "wm" | "hdir" => return Some(Direction::Half),
        // Of an anisotropic layer.
        "t" | "x" | "ta" | "anisotropict" | "anisotropyt" => return Some(Direction::Tangent),
        "b" | "y" | "ba" | "anisotropicb" | "anisotropyb" => return Some(Direction::Bitangent),
        _ => {}
    }
    // What holds the name of another is asked for first: binormal, halfview.
    if has(&["binormal", "bitangent"]) {
        Some(Direction::Bitangent)
    } else if has(&["half"]) {
        Some(Direction::Half)
    } else if has(&["normal"]) {
        Some(Direction::Normal)
    } else if has(&["tangent"]) {
        Some(Direction::Tangent)
    } else if has(&["light", "incoming", "incident", "sundir"]) {
        Some(Direction::Wi)
    } else if has(&["view", "eye", "camera", "outgoing"]) {
        Some(Direction::Wo)
    } else {
        None
    }
}

/// Whether a vector may have this name: a width or a slider in three components is something else.
pub(super) fn is_colour(name: &str) -> bool {
    let name = &*plain(name);
    let parts = [
        "f0",
        "r0",
        "f90",
        "color",
        "colour",
        "albedo",
        "rho",
        "diffuse",
        "reflect",
        "radiance",
        "intensity",
        "compensation",
    ];
    let names = ["kd", "ks", "cdiff", "cspec", "specular", "energycompensation", "sheen", "attenuation"];
    names.contains(&name) || parts.iter().any(|part| name.contains(part))
}

/// What a parameter of a material is taken to be where nobody says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Known {
    /// Searched over a range from a default.
    Searched { low: f64, high: f64, default: f64, scale: Scale },
    /// A factor that is left out by this value.
    Fixed(f64),
}

/// The parameter of a well-known name.
///
/// Reflectances are 1 unless set: a white surface is what shows whether energy is kept. Roughness starts above 0, where
/// most models are singular by design.
pub(super) fn known(name: &str, size: usize) -> Option<Known> {
    let name = plain(name);
    let name = ["material", "mat", "u", "brdf", "base", "k"]
        .into_iter()
        .find_map(|noise| name.strip_prefix(noise).filter(|rest| rest.len() > 3))
        .unwrap_or(&name);
    let even = |low, high, default| Some(Known::Searched { low, high, default, scale: Scale::Linear });
    let log = |low, high, default| Some(Known::Searched { low, high, default, scale: Scale::Logarithmic });
    if name.contains("light") && ["color", "colour", "intensity", "radiance"].iter().any(|part| name.contains(part)) {
        return Some(Known::Fixed(1.0));
    }
    match name {
        _ if size > 2 && !is_colour(name) => return None,
        "a" | "alpha" | "alphag" | "ggxalpha" | "roughnessalpha" | "alpharoughness" | "ax" | "ay" | "at" | "ab"
        | "alphax" | "alphay" | "alphat" | "alphab" | "alphatb" | "linearroughness" => return log(0.002, 1.0, 0.25),
        "a2" | "alpha2" | "alphasq" | "asq" | "alphasquared" | "roughness4" => return log(4e-6, 1.0, 0.0625),
        "f0" | "specularf0" | "specularcolor" | "speccolor" | "r0" | "albedo" | "rho" | "kd" | "ks" | "color"
        | "basecolor" | "diffuse" | "diffusecolor" | "diffusealbedo" | "diffusereflectance" | "reflectance0"
        | "reflectivity" | "cdiff" | "cspec" | "c" => return even(0.0, 1.0, 1.0),
        "reflectance" | "specular" | "specularlevel" => return even(0.0, 1.0, 0.5),
        "metallic" | "metalness" | "metal" | "metallicness" | "subsurface" | "sheen" | "sheentint" | "speculartint"
        | "clearcoat" | "anisotropic" | "anisotropy" | "flatness" | "retroreflectivity" => return even(0.0, 1.0, 0.0),
        "clearcoatgloss" => return even(0.0, 1.0, 1.0),
        "ior" | "eta" | "indexofrefraction" => return even(1.01, 3.0, 1.5),
        "shininess" | "exponent" | "specularpower" | "specularexponent" | "power" => return log(1.0, 1000.0, 32.0),
        "glossiness" | "smoothness" | "gloss" => return even(0.0, 0.95, 0.5),
        "strength" | "clearcoatstrength" | "factor" => return even(0.0, 1.0, 1.0),
        "sigma" => return even(0.0, 1.0, 0.5),
        "f90" | "specularf90" | "reflectance90" | "occlusion" | "ao" | "visibility" | "shadow" | "attenuation"
        | "radiance" | "irradiance" | "lightcolor" | "lightintensity" | "intensity" | "specularweight"
        | "specularfactor" | "weight" | "energycompensation" | "specularintensity" | "diffuseintensity" => {
            return Some(Known::Fixed(1.0));
        }
        _ => {}
    }
    if name.contains("rough") {
        return even(0.05, 1.0, 0.5);
    }
    if name.contains("gloss") || name.contains("smoothness") {
        return even(0.05, 0.95, 0.5);
    }
    if size > 2 {
        // A colour of any other name: of what is lit, or of what lights it.
        let neutral = ["radiance", "intensity", "attenuation", "compensation"];
        if name.contains("emissi") {
            return Some(Known::Fixed(0.0));
        }
        if neutral.iter().any(|part| name.contains(part)) {
            return Some(Known::Fixed(1.0));
        }
        return even(0.0, 1.0, 1.0);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use Direction::{Bitangent, Half, Normal, Tangent, Wi, Wo};

    #[test]
    fn directions_by_their_names() {
        for (want, names) in [
            (
                Wi,
                "wi L l lightDir light_direction LightVector uLightDir dirToLight w_i omega_i incomingDir surfaceToLight",
            ),
            (Wo, "wo V v viewDir view_direction eyeVec toEye cameraDir w_o outgoing vViewDir"),
            (Normal, "N n normal vNormal worldNormal geometryNormal normal_ws nrm clearcoatNormal"),
            (Half, "H h halfVector half_vector wh halfDir"),
            (Tangent, "T X t tangent vTangent Ta anisotropicT"),
            (Bitangent, "B Y b bitangent binormal"),
        ] {
            for name in names.split(' ') {
                assert_eq!(role(name, 3), Some(Role::Along(want, false)), "{name}");
            }
        }
        for name in "lightColor light_position a color albedo f0 viewPosition".split(' ') {
            assert_eq!(role(name, 3), None, "{name}");
        }
    }

    #[test]
    fn cosines_by_their_names() {
        for ((a, b), names) in [
            (
                (Normal, Wi),
                "NoL NdotL n_dot_l dotNL NL nDotL ndotl clampedNdotL cosThetaI cos_theta_i mu_i NdotLClamped N_dot_L cosNL",
            ),
            ((Normal, Wo), "NoV NdotV dotNV cosThetaO n_dot_v absNdotV NdotE"),
            ((Normal, Half), "NoH NdotH dotNH nh cosThetaH"),
            ((Wi, Half), "LoH LdotH dotLH l_dot_h cosThetaD"),
            ((Wo, Half), "VoH VdotH dotVH v_dot_h"),
            ((Wi, Wo), "LoV LdotV l_dot_v"),
            ((Tangent, Half), "ToH TdotH dotTH XdotH XoH"),
            ((Bitangent, Wo), "BoV dotBV b_dot_v YdotV"),
        ] {
            for name in names.split(' ') {
                assert_eq!(role(name, 1), Some(Role::Cosine(a, b)), "{name}");
            }
        }
        for name in "x a u at ab cosTheta roughness no f0 f90 nn alpha k eta".split(' ') {
            assert_eq!(role(name, 1), None, "{name}");
        }
    }

    #[test]
    fn roles_are_read() {
        assert_eq!(Role::parse("-wi"), Ok(Role::Along(Wi, true)));
        assert_eq!(Role::parse("n_dot_l"), Ok(Role::Cosine(Normal, Wi)));
        assert_eq!(Role::parse("x_dot_h"), Ok(Role::Cosine(Tangent, Half)));
        assert!(Role::parse("q").unwrap_err().contains("none of wi, wo"));
        assert!(Role::parse("-n_dot_l").is_err());
    }
}
