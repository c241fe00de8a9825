//! The page of compressors.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Result;
use dsm_testkit::FunctionKind;

use super::functions::Kind;
use super::maps::{self, Subject};
use crate::figures::{machine, table};
use crate::soft_shadows::Page;

/// Numbers of samples a pixel. The least two show what becomes of large steps and do not
/// count in means.
const SAMPLES: [u32; 5] = [4, 16, 64, 256, 1024];
const COUNTED: u32 = 64;

/// The built-in scenes that are baked.
const SCENES: [&str; 4] = ["hairball", "foliage", "smoke", "pipes"];

/// Measures everything, with maps of these files, too, where they are.
///
/// # Errors
///
/// A compressor that breaks the tolerance; else what a file is not.
pub fn page(files: &[PathBuf]) -> Result<Page> {
    let mut text = include_str!("page.md").replace("MACHINE", &machine());
    let mut kinds = Vec::new();
    for kind in FunctionKind::ALL {
        for samples in SAMPLES {
            kinds.push(Kind::measure(kind, samples)?);
            writeln!(std::io::stderr(), "{} {samples}", kind.name())?;
        }
    }
    functions(&kinds, &mut text)?;
    bytes(&kinds, &mut text)?;
    baked(files, &mut text)?;
    Ok(Page { name: "compression", text, pictures: Vec::new() })
}

/// The geometric mean of what is measured of kinds that count.
fn mean(kinds: &[Kind], ratio: impl Fn(&Kind) -> f64) -> f64 {
    let counted: Vec<f64> =
        kinds.iter().filter(|kind| kind.samples >= COUNTED).map(|kind| ratio(kind).ln()).collect();
    (counted.iter().sum::<f64>() / counted.len() as f64).exp()
}

fn functions(kinds: &[Kind], text: &mut String) -> Result<()> {
    writeln!(
        text,
        "## Vertices, errors, time\n\n256 functions of each kind: the mean of N rays, at \
         ε = 0.25/√N. *Shade*: the mean of V′ − V, in ε; below 0 is darker. *Distance*: the \
         root of the mean square. *ns*: for a vertex of V, the median of three rounds in turn on \
         one thread.\n"
    )?;
    let header = [
        "kind",
        "N",
        "V",
        "paper",
        "greedy",
        "min-link",
        "of paper",
        "of greedy",
        "shade greedy",
        "min-link",
        "distance greedy",
        "min-link",
        "ns greedy",
        "min-link",
    ];
    let rows = kinds.iter().map(|kind| {
        let [greedy, min_link] = &kind.outcomes;
        let mut row = vec![kind.kind.name().to_owned(), kind.samples.to_string()];
        row.push(format!("{:.0}", kind.vertices[0]));
        let counts = [kind.vertices[1], greedy.vertices, min_link.vertices];
        row.extend(counts.map(|count| format!("{count:.1}")));
        let ratios = [min_link.vertices / kind.vertices[1], min_link.vertices / greedy.vertices];
        row.extend(ratios.map(|ratio| format!("{ratio:.2}")));
        row.extend([greedy.shade, min_link.shade].map(|shade| format!("{shade:+.2}")));
        row.extend([greedy.distance, min_link.distance].map(|off| format!("{off:.2}")));
        row.extend([greedy.nanoseconds, min_link.nanoseconds].map(|time| format!("{time:.1}")));
        row
    });
    text.push_str(&table(&header, rows));
    let shade = |method: usize| {
        let counted = kinds.iter().filter(|kind| kind.samples >= COUNTED);
        let shades: Vec<f64> = counted.map(|kind| kind.outcomes[method].shade).collect();
        shades.iter().sum::<f64>() / shades.len() as f64
    };
    writeln!(
        text,
        "\nGeometric means from {COUNTED} samples on: {:.3} of the vertices of the paper's \
         compressor, {:.3} of those of the library's greedy one. Mean shade there: greedy \
         {:+.3} ε, min-link {:+.3} ε.\n",
        mean(kinds, |kind| kind.outcomes[1].vertices / kind.vertices[1]),
        mean(kinds, |kind| kind.outcomes[1].vertices / kind.outcomes[0].vertices),
        shade(0),
        shade(1)
    )?;
    Ok(())
}

fn bytes(kinds: &[Kind], text: &mut String) -> Result<()> {
    writeln!(
        text,
        "## Bytes\n\nBytes a pixel of a tile of these functions, block zstd; *raw*: 8 bytes for \
         each vertex of the paper's compressor.\n"
    )?;
    let header = [
        "kind",
        "N",
        "raw",
        "exact, greedy",
        "exact, min-link",
        "ratio",
        "quantized, greedy",
        "quantized, min-link",
        "ratio",
    ];
    let rows = kinds.iter().map(|kind| {
        let [greedy, min_link] = &kind.outcomes;
        let mut row = vec![kind.kind.name().to_owned(), kind.samples.to_string()];
        row.push(format!("{:.1}", 8.0 * kind.vertices[1]));
        for [greedy, min_link] in
            [[greedy.exact, min_link.exact], [greedy.quantized[1], min_link.quantized[1]]]
        {
            row.extend([format!("{greedy:.1}"), format!("{min_link:.1}")]);
            row.push(format!("{:.2}", min_link / greedy));
        }
        row
    });
    text.push_str(&table(&header, rows));
    writeln!(
        text,
        "\nGeometric means from {COUNTED} samples on: exact tiles {:.3} of those of the greedy \
         method, quantized ones {:.3}; of the raw bytes {:.3} and {:.3}. Codec quantized adds \
         {:+.1} % vertices.\n",
        mean(kinds, |kind| kind.outcomes[1].exact / kind.outcomes[0].exact),
        mean(kinds, |kind| kind.outcomes[1].quantized[1] / kind.outcomes[0].quantized[1]),
        mean(kinds, |kind| kind.outcomes[1].exact / (8.0 * kind.vertices[1])),
        mean(kinds, |kind| kind.outcomes[1].quantized[1] / (8.0 * kind.vertices[1])),
        100.0 * mean(kinds, |kind| kind.outcomes[1].quantized[0] / kind.outcomes[1].vertices)
            - 100.0
    )?;
    Ok(())
}

fn baked(files: &[PathBuf], text: &mut String) -> Result<()> {
    writeln!(
        text,
        "## Maps\n\nMaps of 256 × 256 pixels, 16 samples each, ε = 1/16. Bytes of files; \
         *pyramid*: with all mip levels, over the map alone.\n"
    )?;
    let mut subjects =
        SCENES.iter().map(|name| Subject::builtin(name)).collect::<Result<Vec<_>>>()?;
    let mut skipped = Vec::new();
    for path in files {
        match Subject::open(path)? {
            Some(subject) => subjects.push(subject),
            None => skipped.push(file_name(path)),
        }
    }
    let header = [
        "scene",
        "vertices greedy",
        "min-link",
        "exact greedy",
        "min-link",
        "ratio",
        "quantized greedy",
        "min-link",
        "ratio",
        "pyramid greedy",
        "min-link",
    ];
    let mut rows = Vec::new();
    for subject in &subjects {
        let sizes = maps::measure(subject)?;
        let [exact, quantized] = sizes.files;
        let mut row = vec![subject.name.clone()];
        row.extend(exact.map(|file| file.vertices.to_string()));
        for files in [exact, quantized] {
            row.extend(files.map(|file| file.bytes.to_string()));
            row.push(format!("{:.2}", files[1].bytes as f64 / files[0].bytes as f64));
        }
        row.extend(sizes.pyramids.map(|pyramid| format!("{pyramid:.2}")));
        writeln!(std::io::stderr(), "{}", subject.name)?;
        rows.push(row);
    }
    text.push_str(&table(&header, rows));
    if !skipped.is_empty() {
        writeln!(text, "\nNot there, and skipped: {}.", skipped.join(", "))?;
    }
    Ok(())
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
