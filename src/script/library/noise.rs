//! Noises and the sums of octaves made of them.

use super::{Call, Library};
use crate::noise::{self, Model, Recipe};
use crate::script::fault::{Fault, Outcome};
use crate::script::noises::{Kind, Source};
use crate::script::options::Options;
use rhai::Dynamic;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Source>("Noise");
    for &kind in noise::Kind::ALL {
        let name = kind.name();
        lib.def(&format!("{name}(seed)"), kind.doc(), &format!("{name}(7).scaled(4.0)"), move |c| {
            let noise = noise::Noise { kind, seed: c.integer(0)? as u64, frequency: 1.0 };
            Ok(Dynamic::from(Source::new(Kind::One(noise))))
        });
    }
    lib.def("seeded(noise, seed)", "The same noise with another seed.", "gradient(7).seeded(8)", |c| {
        Ok(Dynamic::from(c.source(0)?.seeded(c.integer(1)? as u64)))
    });
    let sentence = "A sum of octaves; `std/fractal` has a function for each model: \"fbm\", \"ridged\", \"altitude1\", \"altitude2\".";
    lib.def(
        "octave_sum(noise, model, options)",
        sentence,
        "octave_sum(gradient(7), \"ridged\", #{ octaves: 9 })",
        octave_sum,
    );
}

fn octave_sum(c: &Call<'_>) -> Outcome<Dynamic> {
    let source = c.source(0)?;
    let Kind::One(noise) = source.kind else {
        return Err(c.wrong(0, "a single noise, not a sum of octaves"));
    };
    let wanted = c.text(1)?;
    let model = Model::ALL.iter().copied().find(|m| m.name() == wanted).ok_or_else(|| {
        let names: Vec<&str> = Model::ALL.iter().map(|m| m.name()).collect();
        Fault::new(format!("there is no sum of octaves called `{wanted}`"))
            .hint(format!("they are {}", names.join(", ")))
    })?;
    // Messages name the function that the user knows.
    let c = &Call { name: model.name(), place: c.place.clone(), ..*c };
    let mut o = Options::new(c, 2)?;
    let count = o.integer("octaves", 1..=32, 8)?;
    let lacunarity = o.number("lacunarity", 1.000001..=16.0, 2.1)?;
    let hurst = o.number("hurst", 0.0..=2.0, 0.9)?;
    let offset = o.number("offset", -4.0..=4.0, 0.6)?;
    let rotate = o.flag("rotate", false)?;
    let detail = o.flag("detail", true)?;
    o.finish()?;
    let count = u32::try_from(count).map_err(|e| Fault::new(e.to_string()))?;
    let recipe = Recipe { noise, model, octaves: count, lacunarity, hurst, offset, rotate };
    recipe.validate().map_err(|e| Fault::new(e.to_string()))?;
    Ok(Dynamic::from(Source { kind: Kind::Sum(recipe, detail), ..source }))
}
