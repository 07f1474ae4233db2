//! A [`Kernel`] for each term: what varies from evaluation to evaluation comes in slices, the rest is a field.

use super::Kernel;
use crate::{Real, fresnel};

macro_rules! kernels {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident),* } [$($input:ident),*] -> $outputs:literal $body:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $($(#[$field_doc])* pub $field: f32,)*
        }
        impl Kernel<{ [$(stringify!($input)),*].len() }, $outputs> for $name {
            #[inline(always)]
            fn evaluate<R: Real<Wide = R>>(&self, [$($input),*]: [R; { [$(stringify!($input)),*].len() }]) -> [R; $outputs] {
                $(let $field = R::from_f64(f64::from(self.$field));)*
                $body
            }
        }
    )*};
}

kernels! {
    /// x
    Conductor {
        /// n
        n,
        /// k
        k
    } [cos] -> 2 { let f = fresnel::conductor_wide::<_, R>(cos, n, k); [f.reflectance, f.transmittance] };
}
