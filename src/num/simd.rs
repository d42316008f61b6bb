//! The instruction set that this machine offers, found once at run time.
//!
//! Hot loops run through [`widest`], which compiles them three times: for any machine,
//! for AVX2 and for AVX-512. No variant fuses or reorders floating point operations, so all give
//! the same bits; only their speed differs.

use std::sync::atomic::{AtomicU8, Ordering};

/// Widest vectors that the hot loops may use.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
#[repr(u8)]
pub enum Level {
    /// Whatever the target guarantees (SSE2 on x86-64, NEON on aarch64).
    Baseline,
    /// 256-bit vectors with AVX2.
    Avx2,
    /// 512-bit vectors with AVX-512 F, DQ, VL and BW.
    Avx512,
}

/// The level in use, or `UNKNOWN`.
static LEVEL: AtomicU8 = AtomicU8::new(UNKNOWN);
const UNKNOWN: u8 = u8::MAX;

/// The level used on this machine.
#[inline]
pub fn simd_level() -> Level {
    // Relaxed: every level gives the same bits, so it does not matter who sees a change when.
    match LEVEL.load(Ordering::Relaxed) {
        0 => Level::Baseline,
        1 => Level::Avx2,
        2 => Level::Avx512,
        _ => limit_simd(Level::Avx512),
    }
}

/// Has the whole process use no wider instructions than those of `level`, and returns what it uses
/// from now on; for benchmarks, and for the test that all levels give the same bits.
#[cold]
pub fn limit_simd(level: Level) -> Level {
    let level = level.min(detect());
    LEVEL.store(level as u8, Ordering::Relaxed);
    level
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
    #[cfg(target_arch = "x86_64")]
    match simd_level() {
        // Safety: the level is never above what was detected on this machine.
        Level::Avx512 => return unsafe { avx512(job) },
        Level::Avx2 => return unsafe { avx2(job) },
        Level::Baseline => {}
    }
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

/// Has something fetched from memory that is soon to be looked at; a hint that changes nothing else.
#[inline(always)]
pub fn fetch<T>(what: &T) {
    #[cfg(target_arch = "x86_64")]
    for line in (0..size_of::<T>()).step_by(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // Safety: prefetching reads nothing, and every x86-64 processor can.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(what).cast::<i8>().wrapping_add(line)) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = what;
}
