//! The machine that times were measured on, as far as it reports it.

/// A processor and how it is used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Machine {
    pub processor: String,
    /// Vector instructions that the field's evaluation runs on.
    pub vectors: &'static str,
    pub threads: usize,
    /// Built with optimisation: times of any other build are not representative.
    pub is_optimised: bool,
}

impl Machine {
    /// This machine.
    pub fn this() -> Self {
        Self {
            processor: processor()
                .unwrap_or_else(|| format!("{} processor", std::env::consts::ARCH)),
            vectors: vectors(),
            threads: rayon::current_num_threads(),
            is_optimised: !cfg!(debug_assertions),
        }
    }
}

/// The processor's name, where the system is Linux and reports it.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    text.lines()
        .find_map(|line| line.strip_prefix("model name"))
        .and_then(|rest| rest.split_once(':'))
        .map(|(_, name)| name.trim().to_owned())
}

/// What `pulp` finds at run time.
fn vectors() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx512f") {
        "AVX-512"
    } else if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        "AVX2 and FMA"
    } else {
        "SSE2"
    }
    #[cfg(target_arch = "aarch64")]
    {
        "NEON"
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    {
        "none"
    }
}
