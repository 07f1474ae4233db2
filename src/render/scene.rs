//! What a picture is taken of.

use super::camera::Camera;
use super::environment::Environment;
use super::light::Light;
use super::shape::Shape;
use crate::material::Material;

/// One shape of one material, its light and its viewer.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What is looked at.
    pub shape: Shape,
    /// What it is made of.
    pub material: Material,
    /// Where the viewer is.
    pub camera: Camera,
    /// Lights of no extent.
    pub lights: Vec<Light>,
    /// The light from infinitely far away.
    pub environment: Environment,
    /// Whether the environment is seen behind the shape; black otherwise.
    pub backdrop: bool,
}
