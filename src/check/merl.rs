//! Measured materials in the format of the MERL database (Matusik et al. 2003): `.binary`.
//!
//! Three little-endian i32 whose product is 90·90·180, then all bins of red, of green and of blue as f64. A bin is a cell
//! of Rusinkiewicz's half and difference angles: i = φd + 180·(θd + 90·θh), θh = ⌊90·√(2θh/π)⌋ with bins that are narrow
//! at the highlight, θd and φd in whole degrees, φd folded by π. Stored numbers are f over 1/1500, 1.15/1500, 1.66/1500.
//!
//! A bin that is negative holds no data: it reads 0, and [`Merl::missing`] counts it apart. Between bins nothing is
//! interpolated: the bin that a pair falls into is what every public reader returns.
//!
//! # What differs from the public readers
//! * f(wi, wo) = f(wo, wi) to the last bit. The folding by π means it so; but readers that rotate wi and round then find
//!   pairs at the edge of a bin on either side of it. Here the angles come from wi + wo and wi − wo, which swapping keeps.
//! * Where φd means nothing, at h = n, it is 0, and pairs in one plane with the normal are at φd = 0, whatever rounding
//!   makes of them: a rotation about the normal does not change f.

use super::subject::Subject;
use crate::frame::{Vector, half_vector};
use core::f64::consts::{FRAC_PI_2, PI};
use core::fmt;
use rayon::prelude::*;
use std::io::{self, Read, Write};

/// The bins in θh, θd and φd.
pub const DIMENSIONS: [usize; 3] = [90, 90, 180];
/// The bins of a channel.
pub const BINS: usize = DIMENSIONS[0] * DIMENSIONS[1] * DIMENSIONS[2];
/// The length of a file in bytes.
pub const LENGTH: usize = HEADER + 3 * 8 * BINS;
/// f of each channel over the number that is stored.
pub const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

const HEADER: usize = 12;
const CHANNELS: [&str; 3] = ["red", "green", "blue"];
/// What stands in a bin without data.
const NO_DATA: f64 = -1.0;
/// Sines of angles below this are rounding: directions are unit to some 1e-16.
const ROUNDING: f64 = 1e-12;

/// A measured material as a [`Subject`] of three channels.
#[derive(Clone)]
pub struct Merl {
    name: String,
    dimensions: [i32; 3],
    /// f, the channels of a bin side by side; 0 where there is no data.
    values: Vec<[f64; 3]>,
    missing: Missing,
}

/// Bins without data: negative ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Missing {
    /// Bins in which some channel is negative.
    pub bins: usize,
    /// Those of them whose centre is a pair of directions above the horizon.
    pub above_horizon: usize,
}

/// Why bytes are no MERL file: displays as one line with the offset.
#[derive(Clone, Debug, PartialEq)]
pub enum MerlError {
    /// The three dimensions do not multiply to [`BINS`].
    Dimensions([i32; 3]),
    /// The file ends before byte [`LENGTH`].
    Truncated {
        /// The bytes that there are.
        length: usize,
    },
    /// The file goes on after byte [`LENGTH`].
    OverLong {
        /// The bytes that there are.
        length: usize,
    },
    /// A bin that is NaN or infinite.
    NotFinite {
        /// The byte that the number starts at.
        offset: usize,
        /// The number.
        value: f64,
        /// The channel, from 0.
        channel: usize,
        /// The bins of θh, θd and φd.
        bin: [usize; 3],
    },
}

impl fmt::Display for MerlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MerlError::Dimensions([a, b, c]) => write!(
                f,
                "byte 0: dimensions {a} × {b} × {c}, but those of a MERL file multiply to 90·90·180 = {BINS}: \
                 another format, or byte order"
            ),
            MerlError::Truncated { length } => write!(
                f,
                "byte {length}: the file ends, {} bytes before the {LENGTH} of a MERL file: fetch it again",
                LENGTH.saturating_sub(*length)
            ),
            MerlError::OverLong { length } => write!(
                f,
                "byte {LENGTH}: a MERL file ends here, and {} more bytes follow: fetch it again, or cut them off",
                length.saturating_sub(LENGTH)
            ),
            MerlError::NotFinite { offset, value, channel, bin: [h, d, p] } => write!(
                f,
                "byte {offset}: {value} in {} at bin θh {h}, θd {d}, φd {p}: bins are finite, negative for no data",
                CHANNELS.get(*channel).unwrap_or(&"a channel")
            ),
        }
    }
}

impl std::error::Error for MerlError {}

impl Merl {
    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// Other dimensions; fewer or more than [`LENGTH`] bytes; a bin that is not finite: each with the offset.
    pub fn parse(name: impl Into<String>, bytes: &[u8]) -> Result<Self, MerlError> {
        let mut dimensions = [0; 3];
        for (dimension, word) in dimensions.iter_mut().zip(bytes.chunks_exact(4)) {
            *dimension = i32::from_le_bytes(word.try_into().unwrap_or_default());
        }
        if bytes.len() < HEADER {
            return Err(MerlError::Truncated { length: bytes.len() });
        }
        let product = dimensions.iter().try_fold(1i64, |product, &d| product.checked_mul(i64::from(d)));
        if product != Some(BINS as i64) || dimensions.iter().any(|&d| d <= 0) {
            return Err(MerlError::Dimensions(dimensions));
        }
        if bytes.len() < LENGTH {
            return Err(MerlError::Truncated { length: bytes.len() });
        }
        if bytes.len() > LENGTH {
            return Err(MerlError::OverLong { length: bytes.len() });
        }
        let mut values = vec![[0.0; 3]; BINS];
        let mut without_data = vec![false; BINS];
        for (index, word) in bytes[HEADER..].chunks_exact(8).enumerate() {
            let value = f64::from_le_bytes(word.try_into().unwrap_or_default());
            let (channel, at) = (index / BINS, index % BINS);
            if !value.is_finite() {
                let offset = HEADER + 8 * index;
                return Err(MerlError::NotFinite { offset, value, channel, bin: bin_of(at) });
            }
            if value < 0.0 {
                without_data[at] = true;
            } else {
                values[at][channel] = value * SCALES[channel];
            }
        }
        let mut missing = Missing::default();
        for at in (0..BINS).filter(|&at| without_data[at]) {
            missing.bins += 1;
            missing.above_horizon += usize::from(above_horizon(pair(bin_of(at).map(|i| i as f64 + 0.5))));
        }
        Ok(Merl { name: name.into(), dimensions, values, missing })
    }

    /// Reads a file: no more of it than says that it is too long.
    ///
    /// # Errors
    /// Those of the reader, and of [`Merl::parse`] as [`io::ErrorKind::InvalidData`].
    pub fn read(name: impl Into<String>, input: impl Read) -> io::Result<Self> {
        let mut bytes = Vec::new();
        input.take(LENGTH as u64 + 1).read_to_end(&mut bytes)?;
        Merl::parse(name, &bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
    }

    /// How many bins hold no data.
    pub fn missing(&self) -> Missing {
        self.missing
    }

    /// f in a bin of θh, θd and φd, 0 where there is no data; nothing out of [`DIMENSIONS`].
    pub fn bin(&self, bin: [usize; 3]) -> Option<[f64; 3]> {
        let inside = bin.iter().zip(DIMENSIONS).all(|(i, n)| *i < n);
        self.values.get(index_of(bin)).copied().filter(|_| inside)
    }
}

impl fmt::Debug for Merl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Merl").field("name", &self.name).field("missing", &self.missing).finish_non_exhaustive()
    }
}

impl Subject for Merl {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn channels(&self) -> usize {
        3
    }

    /// f of the bin that the pair falls into; 0 below the horizon.
    fn evaluate(&self, wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]) {
        let value = if above_horizon((wi, wo)) { self.values.get(index_of(bin(wi, wo))) } else { None };
        for (f, value) in f.iter_mut().zip(value.copied().unwrap_or_default()) {
            *f = value;
        }
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = vec![
            "MERL: φd is folded by π, so reciprocity holds by construction and says nothing about the measurement"
                .to_owned(),
            "MERL: f is that of the nearest bin, a step function: what it steps by is not resolved by any budget"
                .to_owned(),
        ];
        if self.missing.bins > 0 {
            notes.push(format!(
                "MERL: {} of {BINS} bins are negative, which means no data, and count as 0; the centres of {} of them \
                 are above the horizon",
                self.missing.bins, self.missing.above_horizon
            ));
        }
        if self.dimensions.map(|d| d as usize) != DIMENSIONS {
            notes.push(format!("MERL: the dimensions say {:?}, and the bins are read as 90, 90, 180", self.dimensions));
        }
        notes
    }
}

/// The bins of θh, θd and φd that a pair of directions falls into. Swapping the two changes nothing.
pub fn bin(wi: Vector<f64>, wo: Vector<f64>) -> [usize; 3] {
    let (h, d) = (half_vector(wi, wo), wi - wo);
    let across = h.sin_squared().sqrt();
    let theta_h = across.atan2(h.z);
    // |wi + wo| = 2 cos θd and |wi − wo| = 2 sin θd.
    let theta_d = d.length_squared().sqrt().atan2(h.length_squared().sqrt());
    let phi_d = if across <= ROUNDING { 0.0 } else { folded(h, d, across) };
    let cell = |share: f64, n: usize| ((share * n as f64).max(0.0) as usize).min(n - 1);
    [
        cell((theta_h / FRAC_PI_2).sqrt(), DIMENSIONS[0]),
        cell(theta_d / FRAC_PI_2, DIMENSIONS[1]),
        cell(phi_d / PI, DIMENSIONS[2]),
    ]
}

/// φd in [0, π): the azimuth of wi − wo about h, from the plane of h and the normal, of either sign of the difference.
fn folded(h: Vector<f64>, d: Vector<f64>, across: f64) -> f64 {
    let length = h.length_squared().sqrt();
    let (cos_phi, sin_phi) = (h.x / across, h.y / across);
    let x = (h.z * (cos_phi * d.x + sin_phi * d.y) - across * d.z) / length;
    let mut y = cos_phi * d.y - sin_phi * d.x;
    if y.abs() <= ROUNDING {
        y = 0.0;
    }
    match (x, y) {
        (_, 0.0) => 0.0,
        (x, y) if y < 0.0 => (-y).atan2(-x),
        (x, y) => y.atan2(x),
    }
}

/// A pair of directions at these coordinates in bins, which need not be whole: (wi, wo), the half vector towards +x.
///
/// The pair may be below the horizon.
pub fn pair([theta_h, theta_d, phi_d]: [f64; 3]) -> (Vector<f64>, Vector<f64>) {
    let share = theta_h / DIMENSIONS[0] as f64;
    let (sin_h, cos_h) = (FRAC_PI_2 * share * share).sin_cos();
    let (sin_d, cos_d) = (FRAC_PI_2 * theta_d / DIMENSIONS[1] as f64).sin_cos();
    let (sin_p, cos_p) = (PI * phi_d / DIMENSIONS[2] as f64).sin_cos();
    let turned = |x: f64, y: f64| Vector::new(cos_h * x + sin_h * cos_d, y, cos_h * cos_d - sin_h * x);
    (turned(sin_d * cos_p, sin_d * sin_p), turned(-sin_d * cos_p, -sin_d * sin_p))
}

fn above_horizon((wi, wo): (Vector<f64>, Vector<f64>)) -> bool {
    wi.z > 0.0 && wo.z > 0.0
}

fn index_of([theta_h, theta_d, phi_d]: [usize; 3]) -> usize {
    phi_d + DIMENSIONS[2] * (theta_d + DIMENSIONS[1] * theta_h)
}

fn bin_of(index: usize) -> [usize; 3] {
    let (rest, phi_d) = (index / DIMENSIONS[2], index % DIMENSIONS[2]);
    [rest / DIMENSIONS[1], rest % DIMENSIONS[1], phi_d]
}

/// Where a bin is sampled: its centre, or a point of the part that is above the horizon; nothing of a bin below it.
fn site(bin: [usize; 3]) -> Option<(Vector<f64>, Vector<f64>)> {
    let centre = bin.map(|i| i as f64 + 0.5);
    if above_horizon(pair(centre)) {
        return Some(pair(centre));
    }
    // The lower cosine is cos θh cos θd − sin θh sin θd |cos φd|: this corner has the bin's highest.
    let nearest_to_upright = bin[2] as f64 + if 2 * bin[2] < DIMENSIONS[2] { 1.0 } else { 0.0 };
    let corner = [bin[0] as f64, bin[1] as f64, nearest_to_upright];
    let towards_centre = |t: f64| pair([0, 1, 2].map(|axis| corner[axis] + t * (centre[axis] - corner[axis])));
    // Half as far as the horizon allows.
    let (mut above, mut below) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (above + below);
        if above_horizon(towards_centre(middle)) { above = middle } else { below = middle }
    }
    Some(towards_centre(0.5 * above)).filter(|_| above > 0.0)
}

/// Writes a subject of one or three channels as a MERL file: f at the centre of each bin.
///
/// Bins whose centre is below the horizon take a point of theirs that is above it; those wholly below it hold −1, no data.
/// An anisotropic subject is written as it is for half vectors towards +x.
///
/// # Errors
/// Those of `out`; [`io::ErrorKind::InvalidData`] for another number of channels, or for an f that is not finite or
/// negative, which the format has no number for.
pub fn write(subject: &dyn Subject, out: &mut dyn Write) -> io::Result<()> {
    let refused = |message: String| io::Error::new(io::ErrorKind::InvalidData, message);
    let channels = subject.channels();
    if !matches!(channels, 1 | 3) {
        return Err(refused(format!("a MERL file holds 3 channels, and {} has {channels}", subject.name())));
    }
    let sites: Vec<Option<(Vector<f64>, Vector<f64>)>> = (0..BINS).into_par_iter().map(|at| site(bin_of(at))).collect();
    let values: Vec<f64> = sites
        .par_chunks(DIMENSIONS[2])
        .flat_map_iter(|sites| {
            let pairs: Vec<_> = sites.iter().flatten().copied().collect();
            let mut f = vec![0.0; channels * pairs.len()];
            subject.evaluate_many(&pairs, &mut f);
            let mut f = f.into_iter();
            let mut values = Vec::with_capacity(channels * sites.len());
            for site in sites {
                values.extend((0..channels).map(|_| site.and_then(|_| f.next()).unwrap_or(NO_DATA)));
            }
            values
        })
        .collect();
    for dimension in DIMENSIONS {
        out.write_all(&(dimension as i32).to_le_bytes())?;
    }
    let mut bytes = Vec::with_capacity(8 * BINS);
    for (channel, scale) in SCALES.into_iter().enumerate() {
        bytes.clear();
        for (at, (f, site)) in values.chunks_exact(channels).zip(&sites).enumerate() {
            let value = f.get(channel.min(channels - 1)).copied().unwrap_or(NO_DATA);
            if site.is_some() && !(value.is_finite() && value >= 0.0) {
                let [h, d, p] = bin_of(at);
                return Err(refused(format!(
                    "{} is {value} in {} at bin θh {h}, θd {d}, φd {p}: a bin holds a finite f of at least 0",
                    subject.name(),
                    CHANNELS[channel]
                )));
            }
            let stored = if site.is_some() { value / scale } else { NO_DATA };
            bytes.extend_from_slice(&stored.to_le_bytes());
        }
        out.write_all(&bytes)?;
    }
    out.flush()
}
