//! Figure 7: normal shadow maps against deep ones with as many samples.

use anyhow::Result;
use dsm_core::{Footprint, PixelSampling, Receiver, filtered_lookup};
use shadow_maps::detail::Blocking;
use shadow_maps::plain::{DepthMap, DepthMapSettings, PercentageCloserFilter};

use super::machine::machine;
use super::plot::{Panel, svg};
use super::reference::references;
use super::report::{megabytes, table};
use super::sizes::{PAPER_BYTES, packed_depths};
use super::timing::{interleaved, pass};
use super::{Bakes, Report, Stage};

/// Taps between two looks at the clock.
const TAPS_A_PASS: usize = 1 << 18;

/// The paper's figure: samples along a side, seconds for a normal and a deep
/// map, megabytes of each.
const PAPER: [(u32, f64, f64, f64, f64); 6] = [
    (2, 34.0, 45.0, 0.34, 0.49),
    (4, 39.0, 46.0, 1.34, 0.79),
    (8, 60.0, 45.0, 5.34, 1.18),
    (16, 145.0, 46.0, 21.34, 1.53),
    (32, 554.0, 45.0, 85.34, 1.84),
    (64, 2414.0, 45.0, 341.34, 2.20),
];

/// How far answers are from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// The root of the mean square.
    pub root_mean_square: f64,
    /// The largest.
    pub max: f64,
}

impl Deviation {
    fn of(answers: impl Iterator<Item = f64>, references: &[f64]) -> Self {
        let (mut squares, mut max, mut count) = (0.0, 0.0_f64, 0.0);
        for (answer, reference) in answers.zip(references) {
            let off = (answer - reference).abs();
            squares += off * off;
            max = max.max(off);
            count += 1.0;
        }
        Self { root_mean_square: f64::sqrt(squares / count), max }
    }
}

/// One number of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure7Row {
    /// Samples along the side of a pixel; N is its square.
    pub side: u32,
    /// Of percentage closer filtering, and of the deep map.
    pub error: [Deviation; 2],
    /// Of the deep map, against squares around the receivers instead of its own
    /// pixels.
    pub centred_error: Deviation,
    /// Nanoseconds a lookup takes by percentage closer filtering, by the same
    /// one tap after the other, and in the deep map.
    pub nanoseconds: [f64; 3],
    /// Bytes of the depths as `f32` in zstd frames.
    pub packed_depths: u64,
    /// Bytes of the deep map's file, without and with mip levels.
    pub deep_bytes: [u64; 2],
    /// Bytes of the same in codec `exact`.
    pub exact_bytes: u64,
    /// Bytes of the normal map as the paper counts.
    pub paper_bytes: f64,
}

impl Figure7Row {
    /// How many times faster the deep map answers.
    #[must_use]
    pub fn time_ratio(&self) -> f64 {
        self.nanoseconds[0] / self.nanoseconds[2]
    }

    /// How many times smaller the deep map is than one of 4/3 bytes a sample.
    #[must_use]
    pub fn size_ratio(&self) -> f64 {
        self.paper_bytes / self.deep_bytes[0] as f64
    }
}

/// Figure 7, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure7 {
    /// By number of samples, ascending.
    pub rows: Vec<Figure7Row>,
    parameters: String,
}

impl Figure7 {
    /// Measures it.
    ///
    /// # Errors
    ///
    /// What the code under test says.
    pub fn measure(stage: &Stage, bakes: &mut Bakes) -> Result<Self> {
        let checked = stage.checked();
        // In the middle of a pixel, both methods average the same square.
        let middle = |receiver: &Receiver| {
            let position = receiver.position.map(|at| at.floor() + 0.5);
            Receiver { position, ..*receiver }
        };
        let in_middle: Vec<Receiver> = checked.iter().map(middle).collect();
        let references = [references(stage, &in_middle)?, references(stage, &checked)?];
        let mut rows = Vec::new();
        for &side in &stage.effort.sides {
            rows.push(row(stage, bakes, side, [&in_middle, &checked], &references)?);
        }
        let effort = &stage.effort;
        let parameters = format!(
            "Scene `hairball` with opaque hairs, maps of {0} × {0} pixels, filter one pixel wide, \
             {1} receivers seen by the scene's camera in scanline order; errors of {2} of them \
             against {3} other samples each. One thread; medians of {4} rounds, methods \
             interleaved. {5}.",
            effort.map,
            stage.receivers.len(),
            checked.len(),
            effort.reference_samples,
            effort.rounds,
            machine(),
        );
        Ok(Self { rows, parameters })
    }

    /// The page and the plot.
    ///
    /// # Errors
    ///
    /// If the plot can't be drawn.
    pub fn report(&self) -> Result<Report> {
        let square = |side: u32| format!("{side} × {side}");
        let noise = |side: u32| 0.5 / f64::from(side);
        let errors = table(
            &[
                "samples",
                "0.5/√N",
                "PCF RMSE",
                "deep RMSE",
                "PCF max",
                "deep max",
                "deep RMSE, centred",
            ],
            self.rows.iter().map(|row| {
                let [pcf, deep] = row.error;
                vec![
                    square(row.side),
                    format!("{:.4}", noise(row.side)),
                    format!("{:.4}", pcf.root_mean_square),
                    format!("{:.4}", deep.root_mean_square),
                    format!("{:.3}", pcf.max),
                    format!("{:.3}", deep.max),
                    format!("{:.4}", row.centred_error.root_mean_square),
                ]
            }),
        );
        let paper = |side: u32| PAPER.iter().find(|row| row.0 == side);
        let or_none = |value: Option<f64>, decimals: usize| {
            value.map_or_else(|| "–".into(), |value| format!("{value:.decimals$}"))
        };
        let times = table(
            &["samples", "PCF ns", "PCF ns, scalar", "deep ns", "faster", "paper: faster"],
            self.rows.iter().map(|row| {
                let [pcf, scalar, deep] = row.nanoseconds.map(|time| format!("{time:.0}"));
                vec![
                    square(row.side),
                    pcf,
                    scalar,
                    deep,
                    format!("{:.1}", row.time_ratio()),
                    or_none(paper(row.side).map(|row| row.1 / row.2), 1),
                ]
            }),
        );
        let sizes = table(
            &[
                "samples",
                "4/3 B a sample",
                "f32 in zstd",
                "deep, quantized",
                "deep, exact",
                "quantized, mips",
                "quantized smaller than 4/3 B",
                "exact smaller",
                "quantized smaller than zstd",
                "paper: normal",
                "deep",
                "smaller",
            ],
            self.rows.iter().map(|row| {
                let [deep, with_mips] = row.deep_bytes.map(|bytes| bytes as f64);
                let packed = row.packed_depths as f64;
                vec![
                    square(row.side),
                    megabytes(row.paper_bytes),
                    megabytes(packed),
                    megabytes(deep),
                    megabytes(row.exact_bytes as f64),
                    megabytes(with_mips),
                    format!("{:.1}", row.size_ratio()),
                    format!("{:.1}", row.paper_bytes / row.exact_bytes as f64),
                    format!("{:.1}", packed / deep),
                    or_none(paper(row.side).map(|row| row.3), 2),
                    or_none(paper(row.side).map(|row| row.4), 2),
                    or_none(paper(row.side).map(|row| row.3 / row.4), 1),
                ]
            }),
        );
        let page = format!(
            include_str!("figure7.md"),
            errors = errors,
            times = times,
            sizes = sizes,
            parameters = self.parameters
        );
        Ok(Report { name: "figure-7", page, plot: svg(&self.panels())? })
    }

    fn panels(&self) -> [Panel; 3] {
        let curve = |value: &dyn Fn(&Figure7Row) -> f64| {
            let point = |row: &Figure7Row| (f64::from(row.side).powi(2), value(row));
            self.rows.iter().map(point).collect::<Vec<_>>()
        };
        let panel = |title, y, curves| Panel { title, x: "samples a pixel, N", y, curves };
        [
            panel(
                "Error",
                "RMSE",
                vec![
                    ("PCF", curve(&|row| row.error[0].root_mean_square)),
                    ("deep", curve(&|row| row.error[1].root_mean_square)),
                    ("0.5/√N", curve(&|row| 0.5 / f64::from(row.side))),
                ],
            ),
            panel(
                "Time of a lookup",
                "ns",
                vec![
                    ("PCF", curve(&|row| row.nanoseconds[0])),
                    ("deep", curve(&|row| row.nanoseconds[2])),
                ],
            ),
            panel(
                "Size",
                "bytes",
                vec![
                    ("4/3 B a sample", curve(&|row| row.paper_bytes)),
                    ("deep", curve(&|row| row.deep_bytes[0] as f64)),
                    ("f32 in zstd", curve(&|row| row.packed_depths as f64)),
                ],
            ),
        ]
    }
}

fn row(
    stage: &Stage,
    bakes: &mut Bakes,
    side: u32,
    [in_middle, checked]: [&[Receiver]; 2],
    [references, centred]: &[Vec<f64>; 2],
) -> Result<Figure7Row> {
    let samples = side * side;
    let mut settings = DepthMapSettings::new([stage.effort.map; 2], samples)?;
    settings.sampling = PixelSampling::new(samples, 0)?;
    settings.blocking = Blocking::Opaque;
    let depths = DepthMap::sample(&stage.source, &settings)?;
    let stored = bakes.map(stage, side)?;
    let deep = stored.read()?;
    let pcf = PercentageCloserFilter::new(depths.clone(), samples)?;
    // A box one pixel wide reaches the pixel that it is in.
    let deep_light = |receiver: &Receiver| {
        let Ok(light) = filtered_lookup(&deep, receiver, &Footprint::Point);
        light
    };
    let seeded = |index: usize, receiver: &Receiver| pcf.lookup(receiver, index as u64);
    let answers = in_middle.iter().enumerate().map(|(index, at)| seeded(index, at).into());
    let error = [
        Deviation::of(answers, references),
        Deviation::of(in_middle.iter().map(|at| deep_light(at).into()), references),
    ];
    let centred_error = Deviation::of(checked.iter().map(|at| deep_light(at).into()), centred);
    let all = &stage.receivers;
    let length = (TAPS_A_PASS / samples as usize).max(16);
    let (mut first, mut second, mut third) = (0, 0, 0);
    let times = interleaved(
        stage.effort.rounds,
        stage.effort.seconds,
        vec![
            Box::new(|| pass(all, &mut first, length, |index, at| seeded(index, &at))),
            Box::new(|| pass(all, &mut second, length, |i, at| pcf.lookup_scalar(&at, i as u64))),
            Box::new(|| pass(all, &mut third, 4096, |_, at| deep_light(&at))),
        ],
    );
    let nanoseconds = [0, 1, 2].map(|method| times[method]);
    Ok(Figure7Row {
        side,
        error,
        centred_error,
        nanoseconds,
        packed_depths: packed_depths(&depths)?,
        deep_bytes: [stored.bytes, stored.bytes_with_mips],
        exact_bytes: stored.bytes_exact,
        paper_bytes: depths.depths().len() as f64 * PAPER_BYTES,
    })
}
