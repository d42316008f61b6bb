//! Film: size, sampling and exposure.

use super::{Call, Library};
use crate::scene::{Film, Filter, Shutter, Tone};
use crate::script::fault::{Fault, Outcome};
use crate::script::options::Options;
use rhai::Dynamic;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Film>("Film");
    let sentence = "The picture. Options:\n\n- width, height: pixels (800, 600)\n- samples: per pixel (4)\n- noise: standard error at which a pixel has enough of them, as a share of white (0: each gets all), such as 0.005\n- filter: order of the B-spline that weighs them: 1 is the pixel, 2 a tent, 4 the cubic; 0 the centre alone (1)\n- isotropic: whether the spline is one of the distance from the centre (false)\n- bounces: from surface to surface, before light is lost (0: sunlight, and skylight as if nothing stood in its way); a mirror that lights something matt or rough counts as no smoother than that, up to a roughness of 0.5: its images of suns would be met by chance alone, as specks\n- irradiance: where light bounces, pixels between places at which it is gathered, along 64 paths, for the surfaces around them that follow Lambert's law without coat or metal; with 4 and many samples that is much faster than a path from each sample and smoother, but details of that light are lost, and `noise` does not see it (0: a path from each sample)\n- occlusion: where nothing bounces, how far the solid stands in the way of skylight (0: not at all)\n- exposure: stops (0)\n- tone: \"neutral\", \"filmic\" or \"linear\"\n- shutter: seconds for which it is open, from the time of the picture on (0); what moves is seen at as many moments as there are samples, 64 at most, so that something small that crosses more than 64 pixels appears as a row\n- shutter_order: of a B-spline over time instead, around that of the picture, with `shutter` between its knots";
    lib.def("film(options)", sentence, "film(#{ width: 1920, height: 1080, samples: 16 })", film);
}

fn film(c: &Call<'_>) -> Outcome<Dynamic> {
    let default = Film::default();
    let mut o = Options::new(c, 0)?;
    let (side, samples) = (1..=Film::MAX_SIDE.into(), 1..=Film::MAX_SAMPLES.into());
    let most_spacing = Film::MAX_IRRADIANCE_SPACING.into();
    // The ranges fit.
    let film = Film {
        width: o.integer("width", side.clone(), default.width.into())? as u32,
        height: o.integer("height", side, default.height.into())? as u32,
        samples: o.integer("samples", samples, default.samples.into())? as u32,
        noise: o.number("noise", 0.0..=1.0, default.noise)?,
        filter: Filter {
            order: o.integer("filter", 0..=Filter::MAX_ORDER.into(), default.filter.order.into())? as u32,
            isotropic: o.flag("isotropic", default.filter.isotropic)?,
        },
        bounces: o.integer("bounces", 0..=Film::MAX_BOUNCES.into(), default.bounces.into())? as u32,
        irradiance_spacing: o.integer("irradiance", 0..=most_spacing, default.irradiance_spacing.into())?
            as u32,
        occlusion: o.number("occlusion", 0.0..=1e9, default.occlusion)?,
        exposure: o.number("exposure", -64.0..=64.0, default.exposure)?,
        tone: tone(&mut o)?,
        shutter: shutter(&mut o)?,
    };
    o.finish()?;
    Ok(Dynamic::from(film))
}

fn tone(o: &mut Options<'_, '_>) -> Outcome<Tone> {
    let name = o.choice("tone", &Tone::ALL.map(|(_, name)| name))?;
    Ok(Tone::ALL.into_iter().find(|(_, known)| *known == name).map(|(tone, _)| tone).unwrap_or_default())
}

fn shutter(o: &mut Options<'_, '_>) -> Outcome<Shutter> {
    let seconds = o.number("shutter", 0.0..=1e6, 0.0)?;
    let order = o.integer("shutter_order", 0..=Filter::MAX_ORDER.into(), 0)? as u32;
    match (seconds, order) {
        (0.0, 0) => Ok(Shutter::Still),
        (0.0, _) => {
            let fault =
                Fault::new("`shutter_order` of `film` needs `shutter`, the seconds from frame to frame");
            Err(fault.key("shutter_order").hint("for example: shutter: 0.04, shutter_order: 4"))
        }
        (open, 0) => Ok(Shutter::Open(open)),
        (spacing, order) => Ok(Shutter::Spline { order, spacing }),
    }
}
