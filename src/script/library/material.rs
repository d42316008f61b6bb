//! Materials.

use super::{Call, Library};
use crate::scene::{Finish, Material, Matt};
use crate::script::fault::Outcome;
use crate::script::options::Options;
use rhai::Dynamic;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Material>("Material");
    let sentence = "How a solid reflects light, beside its colour; what varies from place to place may be a field, of which what is out of range counts as the nearest in it. Options:\n\n- matt: the law of the matt part: \"lambert\", \"rough\" (plaster, sand) or \"dust\" (a moon)\n- grain: how steep the facets of a rough one are (0 to 1; 0.5)\n- coat: share of the surface that has a clear coat, as a wet stone has (0 to 1; 0)\n- roughness: how blurred the reflections of coat and metal are (0 to 1; 0.3)\n- metal: share that is metal (0 to 1; 0)\n- ior: refractive index of the coat (1 to 4; 1.5; water 1.33, ice 1.31)\n- emission: light that it gives off, a colour\n- bump: a height that is added for the sake of normals alone";
    lib.def("material(options)", sentence, "material(#{ coat: 1.0, roughness: 0.1, ior: 1.33 })", material);
}

fn material(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 0)?;
    let name = o.choice("matt", &Matt::ALL.map(|(_, name)| name))?;
    let matt = Matt::ALL.into_iter().find(|(_, known)| *known == name).map(|(matt, _)| matt);
    let mut finish = [c.host.constant(0.0)?; Finish::COUNT];
    for (node, (_, name, default)) in finish.iter_mut().zip(Finish::ALL) {
        *node = o.share(name, default)?;
    }
    let ior = o.number("ior", 1.0..=4.0, 1.5)?;
    let emission = match o.get("emission") {
        Some(given) => {
            let wanted = "a colour such as \"#ff8800\" or a field";
            if let Ok(Some(color)) = c.constant_color(&given) {
                o.positive("emission", color)?;
            }
            let color = c.varying_color(&given).map_err(|fault| fault.key("emission"))?;
            Some(color.ok_or_else(|| o.mismatch("emission", wanted, &given))?)
        }
        None => None,
    };
    let bump = match o.get("bump") {
        Some(_) => Some(o.field("bump")?.node),
        None => None,
    };
    o.finish()?;
    Ok(Dynamic::from(Material { matt: matt.unwrap_or_default(), finish, ior, emission, bump }))
}
