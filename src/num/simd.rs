//! The instruction set that this machine offers, found once at run time.
//!
//! Hot loops run through [`widest`], which compiles them three times: for any machine,
//! for AVX2 and for AVX-512. No variant fuses or reorders floating point operations, so all give
//! the same bits; only their speed differs.

use std::sync::OnceLock;

/// Widest vectors that the hot loops may use.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Level {
    /// Whatever the target guarantees (SSE2 on x86-64, NEON on aarch64).
    Baseline,
    /// 256-bit vectors with AVX2.
    Avx2,
    /// 512-bit vectors with AVX-512 F, DQ, VL and BW.
    Avx512,
}

/// The level used on this machine.
#[inline]
pub fn simd_level() -> Level {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    *LEVEL.get_or_init(detect)
}

#[cfg(target_arch = "x86_64")]
fn detect() -> Level {
    use std::arch::is_x86_feature_detected as has;
    if has!("avx512f") && has!("avx512dq") && has!("avx512vl") && has!("avx512bw") {
        Level::Avx512
    } else if has!("avx2") {
        Level::Avx2
    } else {
        Level::Baseline
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn detect() -> Level {
    Level::Baseline
}

/// Runs `job` compiled for the widest instruction set at hand. Everything in `job` that should be
/// vectorised must be inlined into it.
#[inline(always)]
pub fn widest<R>(job: impl FnOnce() -> R) -> R {
    at_level(simd_level(), job)
}

/// Runs `job` at a given level, or at the widest lower one that this machine has.
#[inline(always)]
pub fn at_level<R>(level: Level, job: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    match level.min(simd_level()) {
        // Safety: `simd_level` has seen these features on this machine.
        Level::Avx512 => return unsafe { avx512(job) },
        Level::Avx2 => return unsafe { avx2(job) },
        Level::Baseline => {}
    }
    let _ = level;
    job()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,bmi2")]
fn avx512<R>(job: impl FnOnce() -> R) -> R {
    job()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi2")]
fn avx2<R>(job: impl FnOnce() -> R) -> R {
    job()
}
