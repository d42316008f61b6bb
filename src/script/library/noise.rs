//! Noises and the sums of octaves made of them.

use super::{Call, Library};
use crate::diag;
use crate::expr::NodeId;
use crate::field::{Moments, survey};
use crate::noise::{
    self, Allowed, Combination, Hurst, Listing, Model, Noise, Parameter, Recipe, Setting, Settings, Signal,
};
use crate::num::{Interval, Slope};
use crate::script::fault::{Fault, Outcome};
use crate::script::noises::{Kind, Source, Sum};
use crate::script::options::{Options, entries};
use crate::script::value::{VectorField, number};
use rhai::{Array, Dynamic, INT, Map};
use std::any::TypeId;
use std::ops::RangeInclusive;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Source>("Noise");
    for listing in noise::Kind::ALL {
        kind(lib, listing);
    }
    lib.def(
        "tiled(noise, period)",
        "The same noise, repeating after a number of lattice cells, or after one for each axis (0 for never). A sum of octaves repeats if its lacunarity is a whole number.",
        "gradient(7).tiled(8)",
        tiled,
    );
    lib.def("seeded(noise, seed)", "The same noise with another seed.", "gradient(7).seeded(8)", |c| {
        Ok(Dynamic::from(c.source(0)?.seeded(c.integer(1)? as u64)))
    });
    vectors(lib);
    let sentence = "What a noise is like on average, measured at the same 16384 points every time, spread over a cube of 64 cells: mean, variance, min, max, gradient (root mean square of its length) and steepest (the longest one met). With them what is certain of that cube (range, lipschitz), and the continuity class. Spectra are the business of `orogen noise`.";
    lib.def("stats(noise)", sentence, "gradient(7).stats().variance", stats);
    let sentence = "A sum of octaves; `std/fractal` has a function for each model: \"fbm\", \"turbulence\", \"ridged\", \"altitude1\", \"altitude2\".\n\n\
        Options of all models:\n\
        - octaves: how many (1 to 32; 8)\n\
        - first: the coarsest (-16 to 16; 0); below 0, features larger than the noise's are added\n\
        - lacunarity: ratio of the frequencies of successive octaves (above 1 and up to 16; 2.1)\n\
        - hurst: exponent of the amplitudes, 1 smooth, 0 rough: a number (0 to 2; 0.9), an array with a number for each octave, or a field\n\
        - rotate: turn and shift every octave, which hides the lattice (true or false; false)\n\
        - detail: leave out what is smaller than a pixel (true or false; true)\n\n\
        and of the altitude models:\n\
        - offset: added to the octaves (-4 to 4; 0.6, or 0 where the signal is folded)\n\
        - signal: what is made of the octaves (\"plain\", \"turbulent\", \"ridged\"; plain)";
    lib.def(
        "octave_sum(noise, model, options)",
        sentence,
        "octave_sum(gradient(7), \"ridged\", #{ octaves: 9 })",
        octave_sum,
    );
}

/// Declares a kind of noise, with options if it has any.
fn kind(lib: &mut Library<'_>, listing: &'static Listing) {
    let name = listing.name;
    lib.def(&format!("{name}(seed)"), listing.doc, &format!("{name}(7).scaled(4.0)"), move |c| {
        Ok(Dynamic::from(Source::new(Kind::One(Noise::new(listing.plain(), c.integer(0)? as u64)))))
    });
    if listing.parameters.is_empty() {
        return;
    }
    // Other functions may have the same name and number of arguments.
    let types = [TypeId::of::<INT>(), TypeId::of::<Map>()];
    lib.bind_typed(name, types, move |c| {
        let mut o = Options::new(c, 1)?;
        let mut settings = Settings::new(listing.parameters);
        for parameter in listing.parameters {
            let value = o.setting(parameter)?;
            settings.set(parameter.name, value).map_err(|e| Fault::new(e.to_string()).key(parameter.name))?;
        }
        o.finish()?;
        let noise = Noise::new((listing.build)(&settings), c.integer(0)? as u64);
        Ok(Dynamic::from(Source::new(Kind::One(noise))))
    });
    let options: Vec<String> =
        listing.parameters.iter().map(|p| format!("- {}: {} {}", p.name, p.doc, allowed(p))).collect();
    let first = listing.parameters[0];
    lib.document(
        name,
        &format!("{name}(seed, options)"),
        &format!("The same with options:\n\n{}", options.join("\n")),
        &format!("{name}(7, #{{ {}: {} }})", first.name, literal(first.allowed.default())),
    );
}

/// What a parameter may be, in words.
fn allowed(p: &Parameter) -> String {
    let default = match p.allowed {
        Allowed::Direction => "none".to_owned(),
        _ => literal(p.allowed.default()),
    };
    format!("({}; {default})", p.allowed.words())
}

/// A value as scripts write it.
fn literal(v: Setting) -> String {
    match v {
        Setting::Number(v) => format!("{v}"),
        Setting::Name(v) => format!("\"{v}\""),
        Setting::Flag(v) => format!("{v}"),
        Setting::Direction(v) => format!("{:?}", v.unwrap_or([0.0, 1.0, 0.0])),
        Setting::Numbers(v) => format!("{v:?}"),
    }
}

fn tiled(c: &Call<'_>) -> Outcome<Dynamic> {
    let source = c.source(0)?;
    let wrong = || c.wrong(1, "a whole number of cells from 0 to 16777216, or three of them");
    let given = match c.vec3_of(&c.args[1])? {
        Some(v) => v.to_array(),
        None => [c.number(1).map_err(|_| wrong())?; 3],
    };
    if !given.iter().all(|p| p.fract() == 0.0 && (0.0..=16_777_216.0).contains(p)) {
        return Err(wrong());
    }
    Ok(Dynamic::from(source.tiled(given.map(|p| p as u32))?))
}

fn stats(c: &Call<'_>) -> Outcome<Dynamic> {
    /// Cells along an edge of the cube, and points in it.
    const CELLS: f64 = 64.0;
    const POINTS: usize = 1 << 14;
    let source = c.source(0)?;
    let side = CELLS / source.noise().frequency;
    let node = source.lower(c.host)?;
    let samples = survey(&c.host.tape(node)?, side, 0, POINTS);
    let Some(m) = Moments::of(&samples) else { return Ok(Dynamic::UNIT) };
    let cube = [Interval::radius(0.5 * side); 3];
    let slope = c.host.eval(node, &std::array::from_fn(|axis| Slope::coordinate(cube[axis], axis)))?;
    let mut map = Map::new();
    let numbers = [
        ("mean", m.mean),
        ("variance", m.variance),
        ("min", m.min),
        ("max", m.max),
        ("gradient", m.gradient_rms),
        ("steepest", m.steepest),
        ("lipschitz", slope.norm),
    ];
    map.extend(numbers.into_iter().map(|(name, v)| (name.into(), Dynamic::from_float(v))));
    map.insert("range".into(), Dynamic::from(c.host.eval::<Interval>(node, &cube)?));
    map.insert("class".into(), c.host.graph.borrow().class(node).to_string().into());
    Ok(map.into())
}

fn octave_sum(c: &Call<'_>) -> Outcome<Dynamic> {
    let source = c.source(0)?;
    let Kind::One(noise) = source.kind else {
        return Err(c.wrong(0, "a single noise, not a sum of octaves"));
    };
    let wanted = c.text(1)?;
    let names = || Model::NAMED.iter().map(|m| m.name());
    let model = Model::NAMED.iter().copied().find(|m| m.name() == wanted).ok_or_else(|| {
        let fault = Fault::new(format!("there is no sum of octaves called `{wanted}`"));
        let fault = match diag::nearest(&wanted, names()) {
            Some(near) => fault.hint(format!("did you mean \"{near}\"?")),
            None => fault,
        };
        fault.hint(format!("they are {}", names().collect::<Vec<_>>().join(", ")))
    })?;
    // Messages name the function that the user knows, which has no argument for its name.
    let args = [c.args[0].clone(), c.args[2].clone()];
    let c = &Call { name: model.name(), place: c.place.clone(), args: &args, ..*c };
    let mut o = Options::new(c, 1)?;
    let whole = |range: RangeInclusive<i32>| INT::from(*range.start())..=INT::from(*range.end());
    let octaves = o.integer("octaves", whole(Recipe::OCTAVES), 8)?;
    let first = o.integer("first", whole(Recipe::FIRST), 0)?;
    let lacunarity = o.number("lacunarity", Recipe::LACUNARITY, 2.1)?;
    let (hurst, varying) = hurst(c, &mut o)?;
    // The cascades take any signal; in a sum it is what tells the models apart.
    let model = if model.combination == Combination::Sum {
        model
    } else {
        let signals = Signal::ALL.iter().map(|s| s.name()).collect::<Vec<_>>();
        let name = o.choice("signal", &signals)?;
        model.of(Signal::ALL.iter().copied().find(|s| s.name() == name).unwrap_or_default())
    };
    let offset = o.number("offset", Recipe::OFFSET, Recipe::offset_of(model.signal))?;
    let rotate = o.flag("rotate", false)?;
    let detail = o.flag("detail", true)?;
    o.finish()?;
    let (octaves, first) = (octaves as u32, first as i32);
    let recipe = Recipe { noise, model, first, octaves, lacunarity, hurst, offset, rotate };
    recipe.tiles().map_err(|(key, must)| {
        Fault::new("octaves of a noise that repeats must repeat with it").key(key).hint(must)
    })?;
    recipe.validate().map_err(|e| Fault::new(e.to_string()).key(e.field))?;
    Ok(Dynamic::from(Source { kind: Kind::Sum(Sum { recipe, detail, hurst: varying }), ..source }))
}

/// The exponent of the amplitudes: a number, one for each octave, or a field.
fn hurst(c: &Call<'_>, o: &mut Options<'_, '_>) -> Outcome<(Hurst, Option<NodeId>)> {
    const WANTED: &str = "a number from 0 to 2, an array of one to 32 numbers from -2 to 4, or a field";
    let usual = 0.9;
    let Some(given) = o.get("hurst") else { return Ok((Hurst::uniform(usual), None)) };
    if number(&given).is_some() {
        return Ok((Hurst::uniform(o.number("hurst", Recipe::HURST, usual)?), None));
    }
    let wrong = || o.mismatch("hurst", WANTED, &given);
    if let Some(list) = given.read_lock::<Array>() {
        if !(1..=32).contains(&list.len()) {
            return Err(wrong());
        }
        let exponent = |v: &Dynamic| number(v).filter(|h| (-2.0..=4.0).contains(h));
        return Ok((Hurst::octaves(&entries("hurst", &list, exponent, wrong)?), None));
    }
    let field = c.field_of(&given)?.ok_or_else(wrong)?;
    Ok((Hurst::uniform(usual), Some(field.node)))
}

/// A vector of three sources as fields.
fn fields(c: &Call<'_>, parts: [Source; 3]) -> Outcome<Dynamic> {
    let [x, y, z] = parts;
    Ok(Dynamic::from(VectorField([x.lower(c.host)?, y.lower(c.host)?, z.lower(c.host)?])))
}

/// Vectors made of noises, and what is known of a noise.
fn vectors(lib: &mut Library<'_>) {
    lib.def(
        "vector_noise(noise)",
        "A vector of three noises of the same kind, of which none tells anything about another.",
        "vector_noise(gradient(7).scaled(4.0))",
        |c| {
            let source = c.source(0)?;
            fields(c, [source.clone(), source.clone().unrelated(1), source.unrelated(2)])
        },
    );
    lib.def(
        "bounds(noise)",
        "What is proven of a noise over all of space: an object map of its largest absolute value `range`, slope `lipschitz`, and second and third derivatives `hessian` and `third` (infinite where there is no bound).",
        "bounds(gradient(7).scaled(4.0)).lipschitz",
        |c| {
            let b = c.source(0)?.bounds()?;
            let entries = [("range", b.range), ("lipschitz", b.lipschitz), ("hessian", b.hessian), ("third", b.third)];
            let map: Map = entries.into_iter().map(|(k, v)| (k.into(), Dynamic::from_float(v))).collect();
            Ok(Dynamic::from(map))
        },
    );
}
