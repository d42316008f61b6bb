//! Surfaces that tests and benches share, built without the script language.
#![allow(dead_code)] // each test uses some

use orogen::expr::{Graph, NodeId};
use orogen::field::Field;
use orogen::noise::{Gradient, Kind, Noise, Settings};
use orogen::op::{self, Op};

/// Builds expressions; nothing here comes near the limit on nodes.
#[derive(Default)]
pub struct Build(pub Graph);

impl Build {
    pub fn op(&mut self, op: Op, args: &[NodeId]) -> NodeId {
        self.0.op(op, args).expect("a small graph")
    }
    pub fn num(&mut self, c: f64) -> NodeId {
        self.0.constant(c).expect("a small graph")
    }
    pub fn p(&mut self) -> [NodeId; 3] {
        self.0.point().expect("a small graph")
    }
    pub fn add(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.op(Op::Add(op::Add), &[a, b])
    }
    pub fn sub(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.op(Op::Sub(op::Sub), &[a, b])
    }
    pub fn min(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.op(Op::Min(op::Min), &[a, b])
    }
    pub fn max(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.op(Op::Max(op::Max), &[a, b])
    }
    pub fn neg(&mut self, a: NodeId) -> NodeId {
        self.op(Op::Neg(op::Neg), &[a])
    }
    pub fn scaled(&mut self, k: f64, a: NodeId) -> NodeId {
        let k = self.num(k);
        self.op(Op::Mul(op::Mul), &[k, a])
    }
    pub fn shifted(&mut self, a: NodeId, c: f64) -> NodeId {
        let c = self.num(c);
        self.add(a, c)
    }
    /// `|p - c| - r`
    pub fn sphere(&mut self, c: [f64; 3], r: f64) -> NodeId {
        let p = self.p();
        let d: Vec<NodeId> = (0..3).map(|i| self.shifted(p[i], -c[i])).collect();
        let length = self.op(Op::Length(op::Length), &d);
        self.shifted(length, -r)
    }
    /// `N(k p)`
    pub fn noise(&mut self, seed: u64, frequency: f64) -> NodeId {
        let p = self.p();
        self.0
            .noise(Noise::new(Kind::Gradient(Gradient::EDGES), seed).at_frequency(frequency), p)
            .expect("a small graph")
    }
    /// Torus around the y axis.
    pub fn torus(&mut self, big: f64, small: f64) -> NodeId {
        let [x, y, z] = self.p();
        let zero = self.num(0.0);
        let ring = self.op(Op::Length(op::Length), &[x, zero, z]);
        let ring = self.shifted(ring, -big);
        let tube = self.op(Op::Length(op::Length), &[ring, y, zero]);
        self.shifted(tube, -small)
    }
    pub fn field(&self, root: NodeId) -> Field {
        Field::new(&self.0, root)
    }
}

/// Surface (5.11) of the thesis: a sphere with three octaves of noise.
pub fn three_octaves(b: &mut Build) -> NodeId {
    let mut f = b.sphere([0.0; 3], 1.0);
    for (seed, amplitude, frequency) in [(1, 0.3, 4.0), (2, 0.15, 8.0), (3, 0.05, 16.0)] {
        let n = b.noise(seed, frequency);
        let n = b.scaled(amplitude, n);
        f = b.add(f, n);
    }
    f
}

/// Surface (5.29): thin ridges whose gradient is unbounded, which no Lipschitz method can cast.
pub fn square_root_ridges(b: &mut Build) -> NodeId {
    let n = b.noise(5, 6.0);
    let n = b.op(Op::Abs(op::Abs), &[n]);
    let n = b.op(Op::Sqrt(op::Sqrt), &[n]);
    let n = b.scaled(0.3, n);
    let s = b.sphere([0.0; 3], 1.0);
    b.add(s, n)
}

/// A noisy shell a thousandth thick.
pub fn thin_shell(b: &mut Build) -> NodeId {
    let n = b.noise(7, 5.0);
    let n = b.scaled(0.1, n);
    let s = b.sphere([0.0; 3], 1.0);
    let outer = b.add(s, n);
    let inner = b.shifted(outer, 1e-3);
    let inner = b.neg(inner);
    b.max(outer, inner)
}

/// Thin rings and a needle cage: tubes of radius 0.004.
pub fn thin_rings(b: &mut Build) -> NodeId {
    let mut f = b.torus(1.0, 0.004);
    for k in 0..6 {
        let t = b.torus(0.2 + 0.13 * f64::from(k), 0.004);
        f = b.min(f, t);
    }
    let [x, _, z] = b.p();
    let zero = b.num(0.0);
    let rod = b.op(Op::Length(op::Length), &[x, zero, z]);
    let rod = b.shifted(rod, -0.003);
    let ball = b.sphere([0.0; 3], 1.2);
    let rod = b.max(rod, ball);
    b.min(f, rod)
}

/// Low hills seen along the ground.
pub fn hills(b: &mut Build) -> NodeId {
    let [_, y, _] = b.p();
    let n = b.noise(11, 8.0);
    let n = b.scaled(0.03, n);
    let m = b.noise(12, 31.0);
    let m = b.scaled(0.004, m);
    let n = b.add(n, m);
    b.add(y, n)
}

/// Forty balls, every third one carved out.
pub fn balls(b: &mut Build) -> NodeId {
    let mut f = b.sphere([0.0; 3], 0.9);
    for k in 0..40 {
        let t = f64::from(k);
        let c = [libm::sin(t * 2.4), -0.95 + 1.9 * t / 39.0, libm::cos(t * 2.4)];
        let c = c.map(|c| 0.8 * c);
        let s = b.sphere(c, 0.11 + 0.002 * t);
        f = if k % 3 == 0 {
            let s = b.neg(s);
            b.max(f, s)
        } else {
            b.min(f, s)
        };
    }
    f
}

/// A ball with the slopes of a noise that is C1: no bound on how fast they turn.
pub fn slopes_of_wavelets(b: &mut Build) -> NodeId {
    let ball = b.sphere([0.0; 3], 1.0);
    let wavelet = Kind::ALL.iter().find(|k| k.name == "wavelet").expect("a noise of that name");
    let noise = Noise::new((wavelet.build)(&Settings::new(wavelet.parameters)), 4).slope(0);
    let p = b.p();
    let relief = b.0.noise(noise, p).expect("a small graph");
    let relief = b.scaled(0.02, relief);
    b.sub(ball, relief)
}
