//! Where a picture looks: points of the solid that rays through pixels all over it meet.

use crate::cast::{CastStats, Hit, Ray};
use crate::field::{Stopped, Watch};
use crate::num::Interval;
use crate::session::stage::Taken;
use glam::DVec3;

/// Bundles of rays, about, and rays across each: as many as beams of the caster need to be worth it.
const BUNDLES: f64 = 144.0;
const WITHIN: u32 = 4;

/// A point of the solid that the picture shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// The point.
    pub p: DVec3,
    /// Where the ray goes that found it.
    pub direction: DVec3,
    /// Size of a pixel there.
    pub footprint: f64,
}

impl Sight {
    /// The box around it that reaches so many pixels in all directions.
    pub fn region(&self, pixels: f64) -> [Interval; 3] {
        self.p.to_array().map(|c| Interval::around(c, pixels * self.footprint))
    }
}

/// What rays met, and what that cost.
#[derive(Debug)]
pub(super) struct Look {
    pub seen: Vec<Sight>,
    pub stats: CastStats,
}

/// Casts rays all over the picture.
pub(super) fn look(taken: &mut Taken, watch: &Watch<'_>) -> Result<Look, Stopped> {
    let mut look = Look { seen: Vec::new(), stats: CastStats::default() };
    let bundles = bundles(taken);
    for (i, rays) in bundles.iter().enumerate() {
        let mut hits = vec![Hit::MISS; rays.len()];
        taken.caster.first_hits(rays, &mut hits, &mut look.stats, watch.cancel);
        watch.check()?;
        let met = rays.iter().zip(hits).filter(|(_, hit)| hit.is_hit());
        look.seen.extend(met.map(|(ray, hit)| Sight {
            p: ray.at(hit.t),
            direction: ray.direction,
            footprint: taken.scene.view.footprint(hit.t),
        }));
        (watch.progress)((i + 1) as f64 / bundles.len() as f64);
    }
    Ok(look)
}

/// Neighbouring lines of sight, here and there in the picture.
fn bundles(taken: &Taken) -> Vec<Vec<Ray>> {
    let settings = &taken.scene.settings;
    let (width, height) = (f64::from(settings.width), f64::from(settings.height));
    let columns = (BUNDLES * width / height).sqrt().ceil().clamp(1.0, BUNDLES);
    let rows = (BUNDLES / columns).ceil();
    let place = |i: f64, count: f64, size: f64| (i + 0.5) / count * size - 0.5 * f64::from(WITHIN - 1);
    let bundle = |i: u32| {
        let (column, row) = (f64::from(i) % columns, (f64::from(i) / columns).floor());
        let (x, y) = (place(column, columns, width), place(row, rows, height));
        let through = |j: u32| taken.scene.sight(x + f64::from(j % WITHIN), y + f64::from(j / WITHIN));
        (0..WITHIN * WITHIN).filter_map(through).collect()
    };
    (0..(columns * rows) as u32).map(bundle).collect()
}
