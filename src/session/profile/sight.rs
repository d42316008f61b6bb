//! Where a picture looks: points of the solid that rays through pixels all over it meet.

use crate::cast::{CastStats, Hit, Ray};
use crate::field::{Stopped, Watch};
use crate::num::{Interval, sequence};
use crate::session::stage::Taken;
use glam::DVec3;
use std::time::{Duration, Instant};

/// Bundles of rays, about, and rays across each: as many as beams of the caster need to be worth it.
const BUNDLES: f64 = 144.0;
const WITHIN: u32 = 4;

/// After so long as many points will do as have been found, if there are this many.
const PATIENCE: Duration = Duration::from_millis(1500);
const ENOUGH: usize = 64;

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
    let (bundles, start) = (bundles(taken), Instant::now());
    for (i, rays) in scattered(&bundles).enumerate() {
        if start.elapsed() > PATIENCE && look.seen.len() >= ENOUGH {
            break;
        }
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

/// All entries of a list, so that the first few are all over it, too.
fn scattered<T>(list: &[T]) -> impl Iterator<Item = &T> {
    sequence::order(list.len()).into_iter().map(|i| &list[i])
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scattered_lists_have_every_entry_once() {
        for count in [0, 1, 2, 7, 144, 154] {
            let list: Vec<usize> = (0..count).collect();
            let mut order: Vec<usize> = scattered(&list).copied().collect();
            assert!(count < 7 || order.windows(2).all(|pair| pair[0].abs_diff(pair[1]) > 1), "{order:?}");
            order.sort();
            assert_eq!(order, list);
        }
    }
}
