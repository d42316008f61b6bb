//! Noises and the sums of octaves made of them.

use super::{Call, Library};
use crate::noise::{Fractal, Model};
use crate::script::fault::{Fault, Outcome};
use crate::script::noises::{Kind, Source};
use crate::script::options::Options;
use rhai::{Dynamic, INT};

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Source>("Noise");
    lib.def("gradient(seed)", "Gradient noise: smooth hills and hollows about one unit apart, different for every seed.", "gradient(7).scaled(4.0)", |c| {
        let noise = crate::noise::Noise::new(crate::noise::Kind::Gradient, c.integer(0)? as u64, 1.0);
        Ok(Dynamic::from(Source::new(Kind::One(noise.map_err(|e| Fault::new(e.to_string()))?))))
    });
    lib.def("seeded(noise, seed)", "The same noise with another seed.", "gradient(7).seeded(8)", |c| {
        Ok(Dynamic::from(c.source(0)?.seeded(c.integer(1)? as u64)))
    });
    let sentence = "A sum of octaves; `std/fractal` has a function for each model: \"fbm\", \"ridged\", \"altitude1\", \"altitude2\".";
    lib.def("octaves(noise, model, options)", sentence, "octaves(gradient(7), \"ridged\", #{ octaves: 9 })", octaves);
}

fn octaves(c: &Call<'_>) -> Outcome<Dynamic> {
    let source = c.source(0)?;
    let Kind::One(noise) = source.kind else {
        return Err(c.wrong(0, "a single noise, not a sum of octaves"));
    };
    let model = match c.text(1)?.as_str() {
        "fbm" => Model::Fbm,
        "ridged" => Model::Ridged,
        "altitude1" => Model::Altitude1,
        "altitude2" => Model::Altitude2,
        other => {
            return Err(Fault::new(format!("there is no sum of octaves called `{other}`"))
                .hint("they are fbm, ridged, altitude1 and altitude2"));
        }
    };
    let mut o = Options::new(c, 2)?;
    let count = o.integer("octaves", 1..=64, 8)?;
    let lacunarity = o.number("lacunarity", 1.01..=16.0, 2.1)?;
    let hurst = o.number("hurst", 0.0..=4.0, 0.9)?;
    let offset = o.number("offset", -4.0..=4.0, 1.0)?;
    let rotate = o.flag("rotate", false)?;
    let detail = o.flag("detail", true)?;
    o.finish()?;
    let count = u32::try_from(count as INT).map_err(|e| Fault::new(e.to_string()))?;
    let fractal = Fractal { noise, model, octaves: count, lacunarity, hurst, offset, rotate };
    fractal.validate().map_err(|e| Fault::new(e.to_string()))?;
    Ok(Dynamic::from(Source { kind: Kind::Sum(fractal, detail), ..source }))
}
