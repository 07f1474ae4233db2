//! What a picture is taken of.

use super::Progress;
use super::camera::Camera;
use super::environment::Environment;
use super::light::Light;
use super::shape::Shape;
use crate::material::Material;
use crate::material::field::{Property, Scalar};

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

impl Scene {
    /// Measures what the material asks the shape for and is not known yet: the occlusion of a mesh. Renderers call it; who calls it before has the
    /// picture's progress by itself.
    pub fn prepare(&self, progress: &Progress<'_>) {
        if let Shape::Mesh(mesh) = &self.shape
            && reads_occlusion(&self.material)
        {
            mesh.measure_occlusion(progress);
        }
    }
}

/// Whether any number of a material depends on how hidden a point is.
fn reads_occlusion(material: &Material) -> bool {
    let mut reads = false;
    let mut visit = |scalar: &Scalar| reads |= matches!(scalar, Scalar::Of(Property::Occlusion));
    for part in material.parts() {
        part.cover.each(&mut visit);
        part.finish.each(&mut |_| (), &mut visit);
    }
    reads
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::built_in;

    #[test]
    fn materials_that_look_at_hollows_are_known() {
        let of = |name| built_in::by_name(name).and_then(|found| found.material().ok()).expect("built in");
        assert!(reads_occlusion(&of("patina")) && reads_occlusion(&of("worn_metal")));
        assert!(!reads_occlusion(&of("rusty_iron")) && !reads_occlusion(&of("car_paint")));
    }
}
