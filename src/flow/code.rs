//! What a velocity, and the field that it carries, must be able to do.

use crate::num::{Class, Number};
use std::fmt::Debug;

/// A function of space with `N` values that any kind of number may be put through, as a tape is.
pub trait Code<const N: usize>: Debug + Send + Sync {
    /// Continuity class of the least smooth of its values.
    fn class(&self) -> Class;

    /// Whether its values are known to be the gradient of something, of which the derivatives of each are bounded as
    /// those of all three together are.
    fn is_gradient(&self) -> bool {
        false
    }

    /// The function, with the memory that it takes to evaluate it.
    fn runner<T: Number>(&self) -> impl FnMut(&[T; 3]) -> [T; N];
}
