//! Film: the size of a picture, how its pixels gather light, and how that is shown.

use crate::num::BSpline;

/// Picture size, sampling and exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Samples per pixel; the most of them where there is a `noise`.
    pub samples: u32,
    /// Standard error at which a pixel has enough samples, as a share of white on the screen; with 0 each gets all.
    pub noise: f64,
    /// How a pixel weighs its surroundings.
    pub filter: Filter,
    /// How often light is followed from surface to surface before it reaches the eye: 0 is sunlight, and skylight as if
    /// nothing stood in its way.
    pub bounces: u32,
    /// Pixels between places where light that bounces is gathered for what is around them; 0 where every sample follows it
    /// by itself.
    pub irradiance_spacing: u32,
    /// How far the solid stands in the way of skylight where nothing bounces; 0 where it does not.
    pub occlusion: f64,
    /// Exposure in stops.
    pub exposure: f64,
    /// How light becomes brightness on a screen.
    pub tone: Tone,
    /// How long the shutter is open.
    pub shutter: Shutter,
}

impl Film {
    /// Longest side of a picture, in pixels.
    pub const MAX_SIDE: u32 = 65_536;
    /// Most samples per pixel.
    pub const MAX_SAMPLES: u32 = 65_536;
    /// Most bounces.
    pub const MAX_BOUNCES: u32 = 64;
    /// Most pixels between places that share light.
    pub const MAX_IRRADIANCE_SPACING: u32 = 64;
}

impl Default for Film {
    fn default() -> Self {
        Film {
            width: 800,
            height: 600,
            samples: 4,
            noise: 0.0,
            filter: Filter::default(),
            bounces: 0,
            irradiance_spacing: 0,
            occlusion: 0.0,
            exposure: 0.0,
            tone: Tone::default(),
            shutter: Shutter::default(),
        }
    }
}

/// How a pixel weighs its surroundings: by a B-spline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filter {
    /// Order: 1 is the pixel itself, 2 a tent, 4 the cubic; 0 its centre alone.
    pub order: u32,
    /// Whether it is one of the distance from the centre rather than one across times one down.
    pub isotropic: bool,
}

impl Filter {
    /// Highest order: pixels are as wide as the order, and blurred beyond use long before.
    pub const MAX_ORDER: u32 = BSpline::MAX_ORDER;
}

impl Default for Filter {
    fn default() -> Self {
        Filter { order: 1, isotropic: false }
    }
}

/// How light becomes brightness on a screen.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Tone {
    /// As it is up to the bright parts, which roll off and keep their hue.
    #[default]
    Neutral,
    /// Like film: dark parts darker, bright parts rolled off.
    Filmic,
    /// As it is, cut off at white.
    Linear,
}

impl Tone {
    /// All curves, with their names in scripts.
    pub const ALL: [(Tone, &'static str); 3] =
        [(Tone::Neutral, "neutral"), (Tone::Filmic, "filmic"), (Tone::Linear, "linear")];
}

/// How long the shutter is open, around or from the time of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Shutter {
    /// No time at all.
    #[default]
    Still,
    /// So many seconds, from the time of the picture on.
    Open(f64),
    /// A B-spline over time, around that of the picture.
    Spline {
        /// Its order.
        order: u32,
        /// Seconds between its knots, as a rule those from frame to frame.
        spacing: f64,
    },
}
