//! Plans against the general evaluation of the same stack, and each rule at work.

mod stacks;

use brdf::layered::Model;
use brdf::plan::{Plan, Rule};
use stacks::{Random, allowed};

#[test]
fn plans_mean_what_their_stacks_mean() {
    let mut random = Random(1);
    let mut seen = std::collections::HashMap::<Rule, usize>::new();
    let mut worst = 0.0f64;
    for round in 0..3 * 4_000 {
        let model = Model::CLOSED_FORM[round % 3];
        let stack = random.stack(model);
        let plan = Plan::new(&stack).expect("a closed form");
        for applied in plan.applied() {
            *seen.entry(applied.rule).or_default() += 1;
            assert!(applied.layer < stack.layers().len());
        }
        for _ in 0..12 {
            let [wi, wo] = random.pair();
            let (want, got): ([f64; 3], [f64; 3]) = (stack.evaluate(wi, wo), plan.evaluate(wi, wo));
            for ((want, got), bound) in want.into_iter().zip(got).zip(allowed(&stack, [wi, wo])) {
                let error = (got - want).abs();
                worst = worst.max(error / (want + 1e-18));
                assert!(
                    error <= bound,
                    "{wi:?} {wo:?}: {got:e}, but the stack's f is {want:e}, {bound:e} allowed\n{stack:?}\n{plan:?}"
                );
            }
        }
    }
    println!("largest relative difference {worst:e}");
    for rule in Rule::ALL {
        assert!(seen.get(&rule).is_some_and(|times| *times > 20), "{rule} was hardly ever applied: {seen:?}");
    }
}
