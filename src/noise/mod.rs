//! stub replaced by the noise branch
use crate::num::*;
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Noise {
    pub seed: u64,
}
impl Kernel for Noise {
    fn class(&self) -> Class {
        Class::C2
    }
    fn bounds(&self) -> Bounds {
        Bounds { range: 1.037, lipschitz: 3.76, hessian: 14.62, third: 151.4 }
    }
    fn jets(&self, _at: [&[f64]; 3], _out: Jets<'_>) {}
}
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Fractal {
    pub noise: Noise,
}
impl Fractal {
    pub fn class(&self) -> Class {
        Class::C2
    }
    pub fn eval<T: Number>(&self, p: [&T; 3], _footprint: Option<&T>) -> T {
        T::kernel(&self.noise, p)
    }
}
