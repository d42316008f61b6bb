//! Exponential and logarithm.

use crate::num::{Class, Combine, Form, Function, Interval, Real};

/// e^x
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Exp;

impl Function<1> for Exp {
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        x.exp()
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [x.exp()]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        [[x.exp()]]
    }
    fn form(&self, x: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        Form::chord(self, x[0], libm::log)
    }
}

/// Natural logarithm; NaN below zero.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Ln;

impl Function<1> for Ln {
    fn class(&self) -> Class {
        Class::C2
    }
    fn is_defined(&self, [x]: &[Interval; 1]) -> bool {
        x.lo > 0.0
    }
    fn is_undefined(&self, [x]: &[Interval; 1]) -> bool {
        x.hi < 0.0
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        x.ln()
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [R::of(1.0) / x]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        [[-(R::of(1.0) / x.square())]]
    }
    fn form(&self, x: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        if x[0].lo <= 0.0 {
            return Form::constant(self.range(*x));
        }
        Form::chord(self, x[0], |slope| 1.0 / slope)
    }
}
