//! Limits of our own stacks, by the functions that are there for users' tests.

use brdf::check::{StackSubject, Verdict, limits};
use brdf::layered::{Interface, Layer, Model, Stack};

fn stack(model: Model, layers: Vec<Layer<f64, 1>>) -> StackSubject<1> {
    StackSubject::new(model.name(), Stack::new(model, layers).expect("a valid stack"))
}

const CLOSED: [Model; 2] = [Model::Conserving, Model::WeidlichWilkie];

#[test]
fn a_coat_of_index_1_is_no_coat() {
    let bases = [
        Layer::new(Interface::diffuse([0.8], 0.0)),
        Layer::new(Interface::conductor([0.2], [4.0], 0.2)),
        Layer::new(Interface::dielectric(1.7, 0.1)),
    ];
    for model in CLOSED {
        for base in &bases {
            let coated = stack(model, vec![Layer::new(Interface::dielectric(1.0, 0.1)), *base]);
            let bare = stack(model, vec![*base]);
            let finding = limits::agreement(&coated, &bare, 128, 5, limits::AGREEMENT);
            assert_eq!(finding.verdict, Verdict::Pass, "{} {base:?}: {finding}", model.name());
        }
    }
}

#[test]
fn a_conductor_without_absorption_is_a_dielectric() {
    for model in CLOSED {
        let conductor = stack(model, vec![Layer::new(Interface::conductor([1.5], [0.0], 0.2))]);
        let dielectric = stack(model, vec![Layer::new(Interface::dielectric(1.5, 0.2))]);
        let finding = limits::agreement(&conductor, &dielectric, 128, 5, limits::AGREEMENT);
        assert_eq!(finding.verdict, Verdict::Pass, "{finding}");
    }
    let one = stack(Model::Conserving, vec![Layer::new(Interface::dielectric(1.5, 0.2))]);
    let other = stack(Model::Conserving, vec![Layer::new(Interface::dielectric(1.51, 0.2))]);
    assert_eq!(limits::agreement(&one, &other, 128, 5, limits::AGREEMENT).verdict, Verdict::Fail);
}
