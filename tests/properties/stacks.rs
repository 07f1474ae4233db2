//! What must change nothing in a stack, and what must only darken it.

use super::*;

proptest! {
    #[test]
    fn a_matched_coat_changes_nothing(alpha in alpha(), below in layers(), wi in upper(), wo in upper()) {
        let mut coated = vec![Layer::new(Interface::dielectric(1.0, alpha))];
        coated.extend(below.iter().copied());
        let (coated, bare) = (stack(Model::Conserving, coated), stack(Model::Conserving, below));
        for (coated, bare) in coated.evaluate(wi, wo).into_iter().zip(bare.evaluate(wi, wo)) {
            // Directions pass to the bit; two transmittances of 1 to 4 ULP each, and a product for each layer below.
            prop_assert!(close(coated, bare, 16.0), "{} {}", coated, bare);
        }
    }

    #[test]
    fn a_layer_split_by_a_matched_interface_is_the_same(
        top in microfacet_layer(), below in layers(), share in scaled(0, 100, 100), alpha in alpha(),
        wi in upper(), wo in upper()
    ) {
        let Interface::Microfacet { n, .. } = top.interface else { unreachable!() };
        let (sigma, d) = (top.medium.sigma, top.medium.thickness);
        let matched = Layer::new(Interface::conductor(n, [0.0; 3], alpha)).over(sigma, d * (1.0 - share));
        let mut split = vec![top.over(sigma, d * share), matched];
        split.extend(below.iter().copied());
        let mut whole = vec![top];
        whole.extend(below);
        let [split, whole] = [split, whole].map(|layers| stack(Model::Conserving, layers).evaluate(wi, wo));
        for (channel, (split, whole)) in split.into_iter().zip(whole).enumerate() {
            // As a matched coat, and the absorption's 9 + 9·x ULP of the test above.
            let least = [wi, wo].map(|w| refraction::cos_t(w.z, n[channel]));
            let x = sigma[channel] * d * (1.0 / least[0] + 1.0 / least[1]);
            if x < 600.0 {
                prop_assert!(close(split, whole, 32.0 + 9.0 * x), "{} {}", split, whole);
            }
        }
    }

    #[test]
    fn an_opaque_medium_hides_what_is_below(top in microfacet_layer(), below in layers(), wi in upper(), wo in upper()) {
        // exp(−1e4·2) is 0 in both precisions.
        let mut hidden = vec![top.over([1e4; 3], 1.0)];
        hidden.extend(below);
        for model in Model::CLOSED_FORM {
            let alone = stack(model, vec![top]).evaluate(wi, wo);
            prop_assert_eq!(stack(model, hidden.clone()).evaluate(wi, wo), alone);
        }
    }

    #[test]
    fn absorption_only_darkens(layers in layers(), model in model(), wi in upper(), wo in upper()) {
        let clear = layers.iter().map(|layer| layer.over([0.0; 3], layer.medium.thickness)).collect();
        let (tinted, clear) = (stack(model, layers).evaluate(wi, wo), stack(model, clear).evaluate(wi, wo));
        for (tinted, clear) in tinted.into_iter().zip(clear) {
            // Products and sums of the same numbers by factors ≤ 1 are monotone, rounded too.
            prop_assert!(tinted <= clear, "{} {}", tinted, clear);
        }
    }

    #[test]
    fn channels_do_not_know_of_each_other(layers in layers(), model in model(), wi in upper(), wo in upper()) {
        let all = stack(model, layers.clone()).evaluate(wi, wo);
        for channel in 0..3 {
            let alone: Vec<Layer<f64, 1>> = layers.iter().map(|layer| Layer {
                interface: match layer.interface {
                    Interface::Microfacet { n, k, alpha } => Interface::Microfacet { n: [n[channel]], k: [k[channel]], alpha },
                    Interface::Diffuse { albedo, sigma } => Interface::Diffuse { albedo: [albedo[channel]], sigma },
                },
                medium: layered::Medium { sigma: [layer.medium.sigma[channel]], thickness: layer.medium.thickness },
            }).collect();
            let alone = Stack::new(model, alone).expect("valid").evaluate(wi, wo);
            prop_assert_eq!(all[channel], alone[0]);
        }
    }
}
