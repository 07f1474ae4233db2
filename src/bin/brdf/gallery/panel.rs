//! One panel of a figure: a material on a shape, or a formula on a sphere.

use crate::failure::Failure;
use brdf::Vector;
use brdf::material::{Material, Point};
use brdf::render::camera::{Camera, Orbit};
use brdf::render::environment::Environment;
use brdf::render::film::Tally;
use brdf::render::light::Light;
use brdf::render::shape::Shape;
use brdf::render::torus::Torus;
use brdf::render::{Film, Scene, realtime, sources};
use rayon::prelude::*;

/// Pixels along each side of a panel.
const SIDE: u32 = 240;

/// Points along each side of a pixel.
const POINTS: u32 = 3;

/// What is seen, and from where.
pub(super) struct View {
    pub(super) shape: Shape,
    pub(super) orbit: Orbit,
    pub(super) environment: Environment,
    pub(super) lights: Vec<Light>,
}

/// A light from the upper left.
pub(super) fn key(irradiance: f64) -> Light {
    let towards = Vector::new(-0.5, -0.7, 0.75).normalized();
    Light::Directional { towards, irradiance: [irradiance; 3] }
}

impl View {
    /// A sphere in the studio under a light.
    pub(super) fn studio() -> Result<Self, Failure> {
        let environment = sources::by_name("studio").ok_or_else(|| "the studio is built in".to_owned())?;
        Ok(View { shape: Shape::Sphere, orbit: Orbit::default(), environment, lights: vec![key(1.5)] })
    }

    /// A sphere under a light alone.
    pub(super) fn lit(irradiance: f64) -> Self {
        let environment = Environment::dark();
        View { shape: Shape::Sphere, orbit: Orbit::default(), environment, lights: vec![key(irradiance)] }
    }

    /// The same of a torus, whose inner side is hidden from most of the light.
    pub(super) fn of_torus(self) -> Result<Self, Failure> {
        let orbit = Orbit { elevation: 35.0, distance: 7.2, ..self.orbit };
        Ok(View { shape: Shape::Torus(Torus::new(0.45)?), orbit, ..self })
    }

    /// The same from another distance.
    pub(super) fn from(self, distance: f64) -> Self {
        View { orbit: Orbit { distance, ..self.orbit }, ..self }
    }

    /// The same with a narrow field of view about the centre.
    pub(super) fn close(self, field: f64) -> Self {
        View { orbit: Orbit { field, ..self.orbit }, ..self }
    }

    fn camera(&self) -> Result<Camera, Failure> {
        Ok(Camera::new(&self.orbit, SIDE, SIDE)?)
    }

    /// A material in realtime mode.
    pub(super) fn of(self, material: Material) -> Result<Film, Failure> {
        let camera = self.camera()?;
        let View { shape, environment, lights, .. } = self;
        let scene = Scene { shape, material, camera, lights, environment, backdrop: false };
        Ok(realtime::render::<f64>(&scene, POINTS, &|_| ()))
    }

    /// A BRDF under the lights, without environment: f in sr⁻¹ of two local directions.
    pub(super) fn of_brdf(self, f: impl Fn(Vector<f64>, Vector<f64>) -> [f64; 3] + Sync) -> Result<Film, Failure> {
        let lights = self.lights.clone();
        self.each(|_, wo, to_local| {
            let mut sum = [0.0; 3];
            for light in &lights {
                let arriving = light.at(Vector::new(0.0, 0.0, 0.0));
                let wi = to_local(arriving.towards);
                if wi.z > 0.0 {
                    let f = f(wi, wo);
                    sum = [0, 1, 2].map(|c: usize| sum[c] + f[c] * wi.z * arriving.irradiance[c]);
                }
            }
            sum
        })
    }

    /// A colour at each point.
    pub(super) fn of_colour(self, colour: impl Fn(&Point<f64>) -> [f64; 3] + Sync) -> Result<Film, Failure> {
        self.each(|point, _, _| colour(point))
    }

    /// What `radiance` says of a point, the local view direction and the way to local directions.
    fn each(
        self,
        radiance: impl Fn(&Point<f64>, Vector<f64>, &dyn Fn(Vector<f64>) -> Vector<f64>) -> [f64; 3] + Sync,
    ) -> Result<Film, Failure> {
        let camera = self.camera()?;
        let View { shape, environment, lights, .. } = self;
        let material =
            Material::from(brdf::material::stack::by_name("copper").ok_or_else(|| "copper is built in".to_owned())?);
        let scene = Scene { shape, material, camera, lights, environment, backdrop: false };
        let spread = scene.camera.spread();
        let pixel = |pixel: u32| {
            let mut tally = Tally::default();
            for fragment in realtime::fragments::<f64>(&scene, POINTS, pixel) {
                let value = fragment.hit.as_ref().map_or([0.0; 3], |hit| {
                    let point = scene.shape.point(hit, hit.distance, spread);
                    let wo = hit.frame.to_local(-fragment.ray.direction);
                    radiance(&point, wo, &|w| hit.frame.to_local(w))
                });
                tally.add(value);
            }
            tally
        };
        let tallies: Vec<Tally> = (0..SIDE * SIDE).into_par_iter().map(pixel).collect();
        Ok(Film::new(SIDE, SIDE, &tallies))
    }
}
