//! Where something was measured.

/// The processor's name, cores and widest instructions, and the memory.
pub(crate) fn machine() -> String {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let field = |text: &str, name: &str| {
        let line = text.lines().find(|line| line.starts_with(name))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    let processors = read("/proc/cpuinfo");
    let name = field(&processors, "model name").unwrap_or_else(|| std::env::consts::ARCH.into());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let memory = field(&read("/proc/meminfo"), "MemTotal")
        .and_then(|total| total.trim_end_matches(" kB").parse::<f64>().ok())
        .map_or_else(String::new, |kib| format!(", {:.0} GiB", kib / 1048576.0));
    format!("{name}, {cores} cores{}{memory}, {}", instructions(), std::env::consts::OS)
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn instructions() -> &'static str {
    if std::is_x86_feature_detected!("avx512f") {
        " with AVX-512"
    } else if std::is_x86_feature_detected!("avx2") {
        " with AVX2"
    } else {
        ""
    }
}

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
const fn instructions() -> &'static str {
    ""
}
