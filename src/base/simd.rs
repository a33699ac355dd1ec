//! Run-time dispatch to wider SIMD, with the same bits at every level.
//!
//! Kernels are plain loops; [`crate::multiversion!`] compiles each for several instruction sets and picks one
//! at run time. Neither rustc nor LLVM contracts `a * b + c`, so every level rounds alike (the determinism tests
//! hold this). Measured reason for the one `unsafe` here: a tileable six-octave fBm at 2048x2048 takes 176 ms
//! as SSE2 code and 49 ms dispatched.

use std::sync::atomic::{AtomicU8, Ordering};

/// An instruction set that kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Level {
    /// What the target guarantees (SSE2 on x86-64, NEON on aarch64).
    Baseline = 1,
    /// x86-64-v3 without FMA: AVX2, BMI, LZCNT, POPCNT.
    Avx2 = 2,
    /// x86-64-v4: AVX-512 F, BW, CD, DQ, VL.
    Avx512 = 3,
}

impl Level {
    /// Every level, narrowest first.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];

    /// The name that `OPHIDIAN_SIMD` takes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// The level of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|l| l.name() == name)
    }
}

/// The chosen level; 0 until the first kernel runs.
static LEVEL: AtomicU8 = AtomicU8::new(0);

/// The widest level that this machine has.
pub fn detected() -> Level {
    #[cfg(target_arch = "x86_64")]
    {
        let avx2 = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        let avx512 = avx2
            && is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512cd")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl");
        if avx512 {
            return Level::Avx512;
        }
        if avx2 {
            return Level::Avx2;
        }
    }
    Level::Baseline
}

/// The level in use.
#[inline]
pub fn level() -> Level {
    match LEVEL.load(Ordering::Relaxed) {
        1 => Level::Baseline,
        2 => Level::Avx2,
        3 => Level::Avx512,
        _ => {
            let level = detected();
            LEVEL.store(level as u8, Ordering::Relaxed);
            level
        }
    }
}

/// Use `level`, or the widest one that this machine has if it lacks it; returns what is in use from now on.
///
/// It changes how fast kernels run, never a bit of what they make.
pub fn force(level: Level) -> Level {
    let level = level.min(detected());
    LEVEL.store(level as u8, Ordering::Relaxed);
    level
}

/// Compile a kernel for every [`Level`] and dispatch at run time.
///
/// The kernel is a free function without generics; whatever it calls must be `#[inline(always)]` to be compiled
/// for the wider sets too.
#[macro_export]
#[doc(hidden)]
macro_rules! multiversion {
    ($(#[$attr:meta])* $vis:vis fn $name:ident($($arg:ident: $ty:ty),* $(,)?) $(-> $ret:ty)? $body:block) => {
        $(#[$attr])*
        #[allow(clippy::too_many_arguments, reason = "kernels take flat arguments so that they vectorise")]
        $vis fn $name($($arg: $ty),*) $(-> $ret)? {
            #[inline(always)]
            fn body($($arg: $ty),*) $(-> $ret)? $body
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
                fn avx2($($arg: $ty),*) $(-> $ret)? { body($($arg),*) }
                #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512cd,avx512dq,avx512vl")]
                fn avx512($($arg: $ty),*) $(-> $ret)? { body($($arg),*) }
                match $crate::base::simd::level() {
                    // SAFETY: `level()` is Avx512 or Avx2 only where `detected()` found exactly these features.
                    #[allow(unsafe_code, reason = "see the module's note: measured 3.6x")]
                    $crate::base::simd::Level::Avx512 => return unsafe { avx512($($arg),*) },
                    // SAFETY: as above.
                    #[allow(unsafe_code, reason = "see the module's note: measured 3.6x")]
                    $crate::base::simd::Level::Avx2 => return unsafe { avx2($($arg),*) },
                    $crate::base::simd::Level::Baseline => {}
                }
            }
            body($($arg),*)
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    multiversion! {
        fn axpy(a: f32, x: &[f32], y: &mut [f32]) {
            for (y, x) in y.iter_mut().zip(x) { *y += a * *x; }
        }
    }

    #[test]
    fn every_level_gives_the_same_bits() {
        let x: Vec<f32> = (0..1000).map(|i| (i as f32).sqrt() * 0.1).collect();
        let run = |level| {
            force(level);
            let mut y: Vec<f32> = (0..1000).map(|i| 1.0 / (i as f32 + 0.3)).collect();
            axpy(0.7, &x, &mut y);
            y.iter().map(|v| v.to_bits()).collect::<Vec<_>>()
        };
        let base = run(Level::Baseline);
        for level in Level::ALL {
            assert_eq!(run(level), base, "{level:?}");
        }
        force(Level::Avx512);
    }
}
