//! How much of the light that comes from one direction leaves a patch in another: the laws of
//! [`material`](super::material), mixed as the material of the scene says.

use super::light::Surroundings;
use super::material::{Bounce, Dust, Film, Fresnel, Lambert, Metals, OrenNayar, Phase, Reflectance, Surge};
use super::recent::Recent;
use super::surface::Patch;
use crate::scene::{Finish, Material, Matt};
use glam::DVec3;
use std::sync::{Arc, LazyLock};

/// The moon's surge: its dust is twice as bright with the sun behind the viewer, and half of that is gone at 6 degrees
/// (Hapke 1986).
const SURGE: Surge = Surge { strength: 1.0, width: 0.05 };

/// Metals do not depend on a scene.
static METALS: LazyLock<Metals> = LazyLock::new(Metals::default);

/// A material with the tables that it needs.
#[derive(Clone, Debug)]
pub struct Reflecting {
    material: Material,
    film: Arc<Film>,
}

impl Reflecting {
    /// With the tables of an index of refraction that are kept from before, if there are any.
    pub(super) fn new(material: &Material) -> Reflecting {
        static FILMS: Recent<f64, Arc<Film>> = Recent::new();
        let make = || Arc::new(Film::new(material.ior));
        let film = FILMS.get_or(&material.ior, || Some(make())).unwrap_or_else(make);
        Reflecting { material: *material, film }
    }
}

/// How a patch reflects.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflector<'a> {
    patch: &'a Patch,
    /// The material; matt without it.
    of: Option<&'a Reflecting>,
}

impl<'a> Reflector<'a> {
    /// That of a patch of a material.
    pub fn new(patch: &'a Patch, of: Option<&'a Reflecting>) -> Reflector<'a> {
        Reflector { patch, of }
    }

    /// Whether it looks as bright from everywhere.
    pub fn is_lambertian(&self) -> bool {
        let is_lambert = self.of.is_none_or(|of| of.material.matt == Matt::Lambert);
        is_lambert && self.shares() == [0.0, 0.0, 1.0]
    }

    /// A property of the patch.
    fn finish(&self, finish: Finish) -> f64 {
        self.patch.finish[finish as usize]
    }

    /// Shares of the patch that are metal, coated, and neither.
    fn shares(&self) -> [f64; 3] {
        let (metal, coat) = (self.finish(Finish::Metal), self.finish(Finish::Coat));
        [metal, (1.0 - metal) * coat, (1.0 - metal) * (1.0 - coat)]
    }

    /// Asks the law of one share.
    fn ask<T>(&self, which: usize, question: impl Fn(&dyn Reflectance) -> T) -> T {
        let Patch { albedo, .. } = *self.patch;
        let Some(Reflecting { material, film }) = self.of else {
            return question(&Lambert { albedo });
        };
        let roughness = self.finish(Finish::Roughness);
        match (which, material.matt) {
            (0, _) => question(&METALS.of(albedo, roughness)),
            (1, _) => question(&film.on(albedo, roughness)),
            (_, Matt::Lambert) => question(&Lambert { albedo }),
            (_, Matt::Rough) => question(&OrenNayar { albedo, roughness: self.finish(Finish::Grain) }),
            (_, Matt::Dust) => question(&Dust { albedo, phase: Phase::Ball, surge: SURGE }),
        }
    }

    /// The reflectance function, per steradian.
    pub fn value(&self, to_eye: DVec3, to_light: DVec3) -> DVec3 {
        let normal = self.patch.shading;
        let shares = self.shares().into_iter().enumerate().filter(|(_, share)| *share > 0.0);
        shares.map(|(i, share)| share * self.ask(i, |law| law.value(normal, to_eye, to_light))).sum()
    }

    /// A direction to look for light in, and the share of it that is reflected; with numbers in [0, 1).
    pub fn sample(&self, choice: f64, u: [f64; 2], to_eye: DVec3) -> Option<(DVec3, DVec3)> {
        let [metal, coat, _] = self.shares();
        // Each law is chosen as often as its share says, which therefore does not weigh what it finds.
        let which = usize::from(choice >= metal) + usize::from(choice >= metal + coat);
        let bounce = self.ask(which, |law| law.sample(u, self.patch.shading, to_eye));
        bounce.map(|Bounce { direction, weight }| (direction, weight))
    }

    /// Light of the sky that is reflected, as if nothing stood in its way: by what is matt from all around, by what mirrors
    /// from one direction, or the rougher it is, from more of them.
    pub fn ambient(&self, to_eye: DVec3, around: &Surroundings<'_>) -> DVec3 {
        let Patch { shading, albedo, position, .. } = *self.patch;
        let [metal, coat, matt] = self.shares();
        let all_around = around.ambient(self.patch);
        if metal + coat == 0.0 {
            return albedo * all_around;
        }
        let cosine = shading.dot(to_eye).clamp(0.0, 1.0);
        let Some(Reflecting { film, .. }) = self.of else { return albedo * all_around };
        let roughness = self.finish(Finish::Roughness);
        let (metal_law, coat_law) = (METALS.of(albedo, roughness), film.on(albedo, roughness));
        let at_once = metal * metal_law.at_once(cosine) * Fresnel::Metal { facing: albedo }.at(cosine)
            + coat * coat_law.at_once(cosine);
        let late = metal * metal_law.late(cosine) + coat * coat_law.late(cosine);
        let mirrored = (2.0 * cosine * shading - to_eye).normalize_or(shading);
        let sky = around.radiance(position, mirrored).lerp(all_around, roughness);
        (matt * albedo + late) * all_around + at_once * sky
    }
}
