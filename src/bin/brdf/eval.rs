//! `brdf eval`: JSON Lines in, the same objects with the results out.
fn x() {}
