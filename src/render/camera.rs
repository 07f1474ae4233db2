//! A pinhole camera on an orbit around the origin.

use super::shape::Ray;
use crate::frame::Vector;
use crate::real::Real;

/// The most pixels of a picture.
pub const MOST_PIXELS: u64 = 1 << 26;

/// What a pixel takes of memory while a picture is made: twice a tally of 56 bytes, mean and variance, and what is encoded.
const PIXEL_BYTES: u64 = 150;

/// Where the viewer is, and how much of the world a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// The azimuth in degrees, from −y towards +x: 0 looks along +y.
    pub azimuth: f64,
    /// The elevation above the horizon in degrees, within ±89.9.
    pub elevation: f64,
    /// The distance from the origin, > 0.
    pub distance: f64,
    /// The vertical field of view in degrees, in [1, 170].
    pub field: f64,
}

impl Default for Orbit {
    /// A unit sphere fills nine tenths of the height.
    fn default() -> Self {
        Orbit { azimuth: 0.0, elevation: 20.0, distance: 5.0, field: 25.5 }
    }
}

/// A camera for pictures of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    origin: Vector<f64>,
    /// From the eye to the centre of the picture, to its right edge, to its upper edge.
    forward: Vector<f64>,
    right: Vector<f64>,
    up: Vector<f64>,
    width: u32,
    height: u32,
}

impl Camera {
    /// A camera of so many pixels.
    ///
    /// # Errors
    /// Names what is out of range: a picture without pixels or of more than [`MOST_PIXELS`], and the ranges of [`Orbit`].
    pub fn new(orbit: &Orbit, width: u32, height: u32) -> Result<Self, String> {
        let range = |name: &str, value: f64, low: f64, high: f64| {
            if value >= low && value <= high {
                Ok(())
            } else {
                Err(format!("{name} is {value}; it lies in [{low}, {high}]"))
            }
        };
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 {
            return Err(format!("a picture of {width}×{height} pixels; it has at least 1×1"));
        }
        if pixels > MOST_PIXELS {
            let gigabytes = |pixels: u64| (pixels as f64 * PIXEL_BYTES as f64 * 1e-9).round();
            let (needs, most) = (gigabytes(pixels), gigabytes(MOST_PIXELS));
            return Err(format!(
                "a picture of {width}×{height} pixels needs {needs} GB of memory; it has at most 2²⁶ pixels, which take {most} GB"
            ));
        }
        range("the azimuth", orbit.azimuth, -3600.0, 3600.0)?;
        range("the elevation", orbit.elevation, -89.9, 89.9)?;
        range("the distance", orbit.distance, 1e-3, 1e6)?;
        range("the field of view", orbit.field, 1.0, 170.0)?;
        let (azimuth, elevation) = (orbit.azimuth.to_radians(), orbit.elevation.to_radians());
        let back = Vector::new(elevation.cos() * azimuth.sin(), -elevation.cos() * azimuth.cos(), elevation.sin());
        let right = Vector::new(azimuth.cos(), azimuth.sin(), 0.0);
        let tangent = (0.5 * orbit.field.to_radians()).tan();
        let aspect = f64::from(width) / f64::from(height);
        Ok(Camera {
            origin: back * orbit.distance,
            forward: -back,
            right: right * (tangent * aspect),
            up: back.cross(right) * tangent,
            width,
            height,
        })
    }

    /// Pixels to a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows of pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// How many pixels there are.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The eye, the centre of the picture, and from there to its right and its upper edge.
    pub fn vectors(&self) -> [Vector<f64>; 4] {
        [self.origin, self.forward, self.right, self.up]
    }

    /// The width of a pixel at distance 1.
    pub fn spread(&self) -> f64 {
        2.0 * self.up.length_squared().sqrt() / f64::from(self.height)
    }

    /// The ray through a point of a pixel, counted row by row from the upper left; `within` in [0, 1)², from its own upper left.
    #[inline]
    pub fn ray<R: Real>(&self, pixel: u32, within: [R; 2]) -> Ray<R> {
        let [column, row] = [pixel % self.width, pixel / self.width].map(|at| R::from_f64(f64::from(at)));
        self.ray_through([column + within[0], row + within[1]])
    }

    /// The ray through a point of the picture, in pixels from its upper left corner.
    #[inline(always)]
    pub fn ray_through<R: Real>(&self, [x, y]: [R; 2]) -> Ray<R> {
        let place = |at: R, size: u32| at * R::from_f64(2.0 / f64::from(size)) - R::ONE;
        let (x, y) = (place(x, self.width), place(y, self.height));
        let direction = self.forward.cast::<R>() + self.right.cast::<R>() * x - self.up.cast::<R>() * y;
        Ray { origin: self.origin.cast(), direction: direction.normalized() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_looks_at_the_origin() {
        let camera = Camera::new(&Orbit { azimuth: 30.0, ..Orbit::default() }, 4, 2).expect("valid");
        // The corner between the four pixels in the middle.
        let ray: Ray<f64> = camera.ray(6, [0.0, 0.0]);
        assert!(ray.at(5.0).length_squared() < 1e-28, "{:?}", ray.at(5.0));
        // Upper left: above and to the left.
        let [_, forward, right, up] = camera.vectors();
        let corner: Ray<f64> = camera.ray(0, [0.0, 0.0]);
        assert!(
            corner.direction.dot(up) > 0.0 && corner.direction.dot(right) < 0.0 && corner.direction.dot(forward) > 0.0
        );
        assert!(up.z > 0.0);
    }

    #[test]
    fn sizes_and_angles_have_ranges() {
        let orbit = Orbit::default();
        assert!(Camera::new(&orbit, 0, 4).is_err() && Camera::new(&orbit, 1 << 13, 1 << 13).is_ok());
        let error = Camera::new(&orbit, 1 << 15, 1 << 15).expect_err("too many");
        assert!(error.contains("32768×32768 pixels needs 161 GB") && error.contains("10 GB"), "{error}");
        assert!(Camera::new(&Orbit { field: f64::NAN, ..orbit }, 4, 4).is_err());
        assert!(Camera::new(&Orbit { elevation: 90.0, ..orbit }, 4, 4).is_err());
    }
}
