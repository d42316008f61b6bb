//! How much of the light that comes from one direction leaves a patch in another: the laws of
//! [`material`](super::material), mixed as the material of the scene says.
//!
//! Bumps are not there: they turn the normal `s` that a law is asked about, on a surface whose own normal `n` says what light
//! can come. A law about `s` also answers to directions below that surface, and what it gives to them would be lost, while
//! the sides that bumps turn away from the eye would be black. So light from a direction counts as that from its
//! mirror image in the surface as well,
//!
//! ```text
//! f(v, l) (s . l)+  +  f(v, l') (s . l')+               l' = l - 2 (n . l) n
//! ```
//!
//! as if what leaves below the surface were thrown up by a mirror that lies in it. All light that a law sends out gets out,
//! whatever the bumps (the idea, with other mirrors, is of Schuessler, Heitz, Hanika and Dachsbacher 2017). But no such law
//! is the same with its directions exchanged: while what the eye gets of an even sky is right, of a low sun bumps catch more
//! than there is. If their slopes are distributed like Gauss's, with a mean square of `m^2`, it is `1 + 2 L` times what falls on
//! the level, where
//!
//! ```text
//! L(a) = (exp(-a^2) / (a sqrt(pi)) - erfc(a)) / 2       a = tan(height of the sun) / m
//! ```
//!
//! is what bumps hide of the sun from each other (Smith 1967). So suns and lamps count for one over that. Each bump takes its own
//! slope for `m`, which for slopes up to 0.3 makes it a twentieth more than there is at most, and a tenth less.
//!
//! Where a law mirrors, a light with a size is looked for in two ways: by directions to its disc, which hardly ever are those
//! that a smooth mirror shows, and by directions in which the law mirrors. Of both, what is found counts by how likely
//! it was to be found like that, `p / (p + q)` with the densities `p` of the own way and `q` of the other one: the balance heuristic
//! (Veach and Guibas 1995, *Optimally combining sampling techniques for Monte Carlo rendering*).

use super::light::Surroundings;
use super::material::{AllAround, Bounce, Dust, Film, Lambert, Metals, OrenNayar, Phase, Reflectance, Surge};
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

/// Nor does its dust.
static DUST: LazyLock<AllAround> = LazyLock::new(|| AllAround::new(Phase::Ball, SURGE));

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

/// A direction in which a patch looks for light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drawn {
    /// Which; above the surface, to rounding.
    pub direction: DVec3,
    /// Share of the radiance there that is reflected.
    pub share: DVec3,
    /// The roughness of what reflects it: how blurred it would show an image; 1 for what is matt.
    pub blur: f64,
}

/// A direction in which a patch mirrors lights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Glint {
    /// Which; above the surface.
    pub direction: DVec3,
    /// Share of the radiance there that is reflected.
    share: DVec3,
    /// How likely it was, in 1/sr.
    density: f64,
}

impl Glint {
    /// Radiance that leaves towards the eye of a light that is there, for each unit of its irradiance, if directions to its disc
    /// have a density.
    pub fn lit(&self, density: f64) -> DVec3 {
        // The radiance of a disc is its irradiance over its solid angle.
        self.share * (density * self.density / (self.density + density))
    }
}

/// The number of the law of what is matt, and does not mirror.
const MATT: usize = 2;

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

    /// Whether any of it mirrors.
    pub fn mirrors(&self) -> bool {
        self.shares()[MATT] < 1.0
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

    /// Radiance that leaves towards the eye, for each unit of irradiance by a sun or a lamp on a surface that faces it. With the
    /// density of directions to its disc, what is mirrored counts as far as it is not found by [`Reflector::glint`].
    pub fn lit(&self, to_eye: DVec3, to_light: DVec3, density: Option<f64>) -> DVec3 {
        if self.patch.normal.dot(to_light) <= 0.0 {
            return DVec3::ZERO;
        }
        self.reflected(to_eye, to_light, density) * self.unhidden(to_light)
    }

    /// A direction in which lights are mirrored, for numbers in [0, 1), if what is mirrored is looked at.
    pub fn glint(&self, choice: f64, u: [f64; 2], to_eye: DVec3) -> Option<Glint> {
        let [metal, coat, _] = self.shares();
        let which = usize::from(choice >= metal);
        if choice >= metal + coat {
            return None;
        }
        let normal = self.patch.shading;
        self.ask(which, |law| {
            let gloss = law.gloss()?;
            let Bounce { direction, weight, .. } = gloss.sample(u, normal, to_eye)?;
            let density = gloss.pdf(normal, to_eye, direction);
            let direction = self.risen(direction);
            let share = weight * self.unhidden(direction);
            (self.patch.normal.dot(direction) > 0.0).then_some(Glint { direction, share, density })
        })
    }

    /// The reflectance function, with the cosine, for light that comes from above, whatever else does.
    fn reflected(&self, to_eye: DVec3, to_light: DVec3, density: Option<f64>) -> DVec3 {
        self.about_bump(to_eye, to_light, density) + self.about_bump(to_eye, self.thrown(to_light), density)
    }

    /// Share of a sun's light that bumps such as this one do not hide from one another.
    fn unhidden(&self, to_light: DVec3) -> f64 {
        let Patch { normal, shading, .. } = *self.patch;
        let sines = normal.cross(to_light).length() * normal.cross(shading).length();
        let a = normal.dot(to_light) * normal.dot(shading) / sines;
        // A rational approximation (Walter, Marschner, Li and Torrance 2007).
        let hidden = (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a);
        if a < 1.6 { 1.0 / (1.0 + 2.0 * hidden) } else { 1.0 }
    }

    /// The reflectance function about the bump alone, with its cosine; light may come from below the surface.
    fn about_bump(&self, to_eye: DVec3, to_light: DVec3, density: Option<f64>) -> DVec3 {
        let normal = self.patch.shading;
        let cosine = normal.dot(to_light);
        if cosine <= 0.0 {
            return DVec3::ZERO;
        }
        let shares = self.shares().into_iter().enumerate().filter(|(_, share)| *share > 0.0);
        let value = |law: &dyn Reflectance| {
            let all = law.value(normal, to_eye, to_light);
            let Some((own, gloss)) = density.zip(law.gloss()) else { return all };
            let other = gloss.pdf(normal, to_eye, to_light);
            all - gloss.value(normal, to_eye, to_light) * (other / (own + other))
        };
        let value = |(i, share): (usize, f64)| share * self.ask(i, value);
        cosine * shares.map(value).sum::<DVec3>()
    }

    /// A direction on the other side of the surface.
    fn thrown(&self, direction: DVec3) -> DVec3 {
        direction - 2.0 * self.patch.normal.dot(direction) * self.patch.normal
    }

    /// A direction, thrown up if it is below the surface.
    fn risen(&self, direction: DVec3) -> DVec3 {
        if self.patch.normal.dot(direction) < 0.0 { self.thrown(direction) } else { direction }
    }

    /// A direction to look for light in, with numbers in [0, 1).
    pub fn sample(&self, choice: f64, u: [f64; 2], to_eye: DVec3) -> Option<Drawn> {
        let [metal, coat, _] = self.shares();
        // Each law is chosen as often as its share says, which therefore does not weigh what it finds.
        let which = usize::from(choice >= metal) + usize::from(choice >= metal + coat);
        let Bounce { direction, weight, is_spread } =
            self.ask(which, |law| law.sample(u, self.patch.shading, to_eye))?;
        let direction = self.risen(direction);
        let blur = if is_spread { 1.0 } else { self.finish(Finish::Roughness) };
        Some(Drawn { direction, share: weight, blur })
    }

    /// Light of the sky that is reflected, as if nothing stood in its way: by what is matt from all around, by what mirrors
    /// from one direction, or the rougher it is, from more of them.
    pub fn ambient(&self, to_eye: DVec3, around: &Surroundings<'_>) -> DVec3 {
        let Patch { shading, albedo, .. } = *self.patch;
        let [metal, coat, matt] = self.shares();
        let all_around = around.ambient(self.patch);
        let Some(Reflecting { material, film }) = self.of else { return albedo * all_around };
        let cosine = shading.dot(to_eye).clamp(0.0, 1.0);
        let matt = matt
            * match material.matt {
                Matt::Lambert => albedo,
                Matt::Rough => {
                    OrenNayar { albedo, roughness: self.finish(Finish::Grain) }.from_all_around(cosine)
                }
                Matt::Dust => albedo * DUST.at(cosine),
            };
        if metal + coat == 0.0 {
            return matt * all_around;
        }
        let roughness = self.finish(Finish::Roughness);
        let coat_law = film.on(albedo, roughness);
        let at_once = metal * METALS.at_once(albedo, roughness, cosine) + coat * coat_law.at_once(cosine);
        let late = metal * METALS.of(albedo, roughness).late(cosine) + coat * coat_law.late(cosine);
        let mirrored = self.risen((2.0 * cosine * shading - to_eye).normalize_or(shading));
        let sky = around.blurred(self.patch, mirrored, roughness, all_around);
        (matt + late) * all_around + at_once * sky
    }
}

#[cfg(test)]
mod tests {
    use super::super::light::Disc;
    use super::super::material::{Frame, uniform_hemisphere};
    use super::*;
    use crate::num::sequence::point;
    use crate::scene::{Light, Sun};
    use std::f64::consts::{PI, TAU};

    /// A white patch, with a bump that leans so far (the tangent), of these shares of metal and coat.
    fn patch(lean: f64, metal: f64, coat: f64) -> Patch {
        let mut finish = [0.0; Finish::COUNT];
        finish[Finish::Metal as usize] = metal;
        finish[Finish::Coat as usize] = coat;
        finish[Finish::Roughness as usize] = 0.6;
        let shading = DVec3::new(lean, 1.0, 0.3 * lean).normalize();
        Patch { normal: DVec3::Y, shading, albedo: DVec3::ONE, finish, ..Patch::PLAIN }
    }

    #[test]
    fn bumps_make_no_light_of_low_suns() {
        let (count, up) = (1 << 14, DVec3::Y);
        for slope in [0.1, 0.3] {
            for height in [3.0_f64, 5.0, 10.0, 20.0, 45.0] {
                let to_sun = DVec3::new(height.to_radians().cos(), height.to_radians().sin(), 0.0);
                let mut sum = 0.0;
                for i in 0..count {
                    // Gaussian slopes (Box and Muller 1958).
                    let [u, v] = point(3, i, 0);
                    let (lean, around) = (slope * (-2.0 * (1.0 - u).ln()).sqrt(), TAU * v);
                    let shading = DVec3::new(lean * around.cos(), 1.0, lean * around.sin()).normalize();
                    let patch = Patch { shading, albedo: DVec3::ONE, ..Patch::PLAIN };
                    sum += PI * Reflector::new(&patch, None).lit(up, to_sun, None).x / f64::from(count);
                }
                let share = sum / to_sun.y;
                assert!((0.9..1.05).contains(&share), "{slope} {height}: {share} of what falls on the level");
            }
        }
    }

    fn reflecting(matt: Matt) -> Reflecting {
        let node = crate::expr::Graph::default().constant(0.0).unwrap();
        let material = Material { matt, finish: [node; Finish::COUNT], ior: 1.5, emission: None, bump: None };
        Reflecting::new(&material)
    }

    /// A light with a size is as bright found in two ways as it is in one, and a smooth mirror finds it with far less noise.
    #[test]
    fn lights_are_mirrored_as_bright_as_they_are() {
        let to_eye = DVec3::new(-0.5, 0.8, 0.1).normalize();
        let of = reflecting(Matt::Lambert);
        for (metal, coat, lean, roughness) in
            [(0.7, 0.0, 0.0, 0.6), (0.0, 1.0, 0.0, 0.4), (0.5, 0.4, -0.3, 0.5), (1.0, 0.0, -1.5, 0.6)]
        {
            let mut patch = patch(lean, metal, coat);
            patch.finish[Finish::Roughness as usize] = roughness;
            let reflector = Reflector::new(&patch, Some(&of));
            let direction = DVec3::new(0.4, 0.8, -0.2).normalize();
            let sun = Sun { direction, irradiance: DVec3::ONE, size: 40.0, shadows: false };
            let disc = Disc::of(&Light::Sun(sun), DVec3::ZERO, None);
            let density = disc.density().unwrap();
            let (count, mut one, mut two) = (1 << 15, 0.0, 0.0);
            for i in 0..count {
                let from = disc.direction(point(2, i, 0));
                one += reflector.lit(to_eye, from, None).x;
                two += reflector.lit(to_eye, from, Some(density)).x;
                let glint = reflector.glint(point(2, i, 1)[0], point(2, i, 2), to_eye);
                let glint = glint.filter(|glint| disc.holds(glint.direction));
                two += glint.map_or(0.0, |glint| glint.lit(density).x);
            }
            assert!((one / two - 1.0).abs() < 0.02, "{metal} {coat} {lean} {roughness}: {one} {two}");
        }
    }

    #[test]
    fn what_is_asked_for_and_what_is_drawn_are_the_same_light() {
        let of = reflecting;
        // Bright to one side.
        let light = |d: DVec3| 1.0 + d.x;
        let count = 1 << 15;
        for (matt, metal, coat) in [
            (Matt::Lambert, 0.0, 0.0),
            (Matt::Rough, 0.0, 0.0),
            (Matt::Lambert, 0.7, 0.0),
            (Matt::Lambert, 0.0, 1.0),
        ] {
            let of = of(matt);
            for lean in [0.0, 0.5, -2.0] {
                let patch = patch(lean, metal, coat);
                let to_eye = DVec3::new(-0.3, 0.8, 0.2).normalize();
                let reflector = Reflector::new(&patch, Some(&of));
                let (mut asked, mut drawn, mut all) = (0.0, 0.0, 0.0);
                for i in 0..count {
                    let from = Frame::around(DVec3::Y).to_world(uniform_hemisphere(point(1, i, 0)));
                    asked += TAU * reflector.reflected(to_eye, from, None).x * light(from) / f64::from(count);
                    let choice = point(1, i, 1)[0];
                    if let Some(Drawn { direction, share, .. }) =
                        reflector.sample(choice, point(1, i, 2), to_eye)
                    {
                        assert!(direction.y > -1e-12 && (direction.length() - 1.0).abs() < 1e-9);
                        drawn += share.x * light(direction) / f64::from(count);
                        all += share.x / f64::from(count);
                    }
                }
                assert!(
                    (asked / drawn - 1.0).abs() < 0.02,
                    "{matt:?} {metal} {coat} {lean}: {asked} {drawn}"
                );
                assert!((all - 1.0).abs() < 0.01, "{matt:?} {metal} {coat} {lean}: {all} of all light");
            }
        }
    }
}
