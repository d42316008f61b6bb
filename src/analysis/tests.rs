//! Noises against what is known of them exactly.
