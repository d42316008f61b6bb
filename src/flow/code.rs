//! What a velocity, and the field that it carries, must be able to do.

use super::Parts;
use crate::num::{Class, Kernel, Number};
use std::fmt::Debug;

/// A function of space with `N` values that any kind of number may be put through, as a tape is.
pub trait Code<const N: usize>: Debug + Send + Sync {
    /// What it may be made of.
    type Part: Kernel;

    /// Continuity class of the least smooth of its values.
    fn class(&self) -> Class;

    /// Whether its values are known to be the gradient of something, of which the derivatives of each are bounded as
    /// those of all three together are.
    fn is_gradient(&self) -> bool {
        false
    }

    /// What it is made of, where that is simple enough to ask directly: kernels that say the same of every ball.
    fn parts(&self) -> Parts<'_, Self::Part> {
        Parts::Any
    }

    /// The function, with the memory that it takes to evaluate it.
    fn runner<T: Number>(&self) -> impl FnMut(&[T; 3]) -> [T; N];
}
