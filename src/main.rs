//! The program; everything it does is in [`orogen::cli`].
fn main() {}
