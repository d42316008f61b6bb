//! Metal: facets that mirror the share `F` of light, and that light which meets further facets.
//!
//! Facets that mirrored all of it would let the share `E(v)` leave at once ([`Mirrored`]), and send the rest to other
//! facets. Of that, on the average, the share `<E>` leaves after each facet, and each takes its share:
//!
//! ```text
//! F^2 <E>  +  F^3 (1 - <E>) <E>  +  F^4 (1 - <E>)^2 <E>  + ...  =  F^2 <E> / (1 - F (1 - <E>))
//! ```
//!
//! It leaves evenly spread ([`Balanced`]). White metal loses nothing at any roughness, and rough metal is more
//! colourful than smooth metal. (Kulla and Conty 2017, *Revisiting physically based shading at Imageworks*; the first
//! factor squared is Hill's.) `F` is the mean of Schlick's approximation, `facing + (1 - facing) / 21`.

use super::mirrored::Mirrored;
use super::{Balanced, Fresnel, Gloss};
use glam::DVec3;

/// Metals of all colours and roughnesses.
#[derive(Clone, Debug)]
pub struct Metals {
    /// What white ones let go at once.
    mirrored: Mirrored,
    /// What black ones do, which mirror light at grazing angles alone.
    grazing: Mirrored,
}

impl Default for Metals {
    fn default() -> Metals {
        let [mirrored, grazing] =
            [DVec3::ONE, DVec3::ZERO].map(|facing| Mirrored::new(Fresnel::Metal { facing }));
        Metals { mirrored, grazing }
    }
}

impl Metals {
    /// The metal that mirrors such shares of light along the normal, of a roughness from 0 to 1.
    pub fn of(&self, facing: DVec3, roughness: f64) -> Balanced<'_> {
        let mirrored = self.mirrored.of(roughness);
        let share = facing + (DVec3::ONE - facing) / 21.0;
        let rest = share * share * (1.0 - mirrored.left()) / (1.0 - share * mirrored.left());
        Balanced { gloss: Gloss::new(roughness, Fresnel::Metal { facing }), mirrored, rest }
    }

    /// The share of light from all around that the metal mirrors at once towards an eye at a cosine: Schlick's approximation is
    /// a mean of white and black.
    pub fn at_once(&self, facing: DVec3, roughness: f64, cos: f64) -> DVec3 {
        let [white, black] = [&self.mirrored, &self.grazing].map(|table| table.of(roughness).at(cos));
        white * facing + black * (DVec3::ONE - facing)
    }
}

#[cfg(test)]
mod tests {
    use super::super::schlick;
    use super::super::tests::{albedo, tilted};
    use super::*;

    #[test]
    fn white_metal_loses_no_light() {
        let metals = Metals::default();
        for roughness in [0.35, 0.5, 0.73, 1.0] {
            let white = metals.of(DVec3::ONE, roughness);
            for mu in [0.05, 0.1, 0.37, 0.7, 1.0] {
                let all = albedo(&white, DVec3::Z, tilted(mu)).x;
                assert!((all - 1.0).abs() < 3e-3, "{roughness} {mu}: {all}");
            }
        }
    }

    #[test]
    fn coloured_metal_lets_go_what_its_law_says() {
        let (metals, copper) = (Metals::default(), DVec3::new(0.9, 0.3, 0.05));
        for (roughness, mu) in [(0.35, 0.9), (0.5, 0.2), (0.73, 0.5), (1.0, 0.1), (1.0, 1.0)] {
            let law = metals.of(copper, roughness);
            let known = metals.at_once(copper, roughness, mu) + law.late(mu);
            let seen = albedo(&law, DVec3::Z, tilted(mu));
            assert!((known - seen).abs().max_element() < 5e-3, "{roughness} {mu}: {known} {seen}");
        }
    }

    #[test]
    fn rough_metal_is_darker_and_more_colourful_than_smooth() {
        let gold = DVec3::new(1.0, 0.78, 0.34);
        let seen = [0.35, 0.6, 1.0].map(|r| albedo(&Metals::default().of(gold, r), DVec3::Z, tilted(0.9)));
        for pair in seen.windows(2) {
            assert!(pair[1].z < pair[0].z && pair[1].z / pair[1].y < pair[0].z / pair[0].y, "{seen:?}");
        }
    }

    #[test]
    fn the_mean_share_is_that_of_all_angles() {
        let facing = DVec3::new(0.2, 0.5, 0.9);
        let steps = 10_000;
        let mean: DVec3 = (0..steps)
            .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
            .map(|cos| 2.0 * cos * schlick(cos, facing) / f64::from(steps))
            .sum();
        assert!((mean - facing - (DVec3::ONE - facing) / 21.0).length() < 1e-6, "{mean}");
    }
}
