//! Shadows by rays that are traced only where visibility can have changed.

use dsm_core::detail::{LightShape, Occlusion};
use dsm_core::{AreaLight, Facing, LightVisibility, OcclusionTracer, ShadedPoint, Transmittance};
use glam::DVec3;

use super::blockers::{Blocker, Blockers};
use super::light_cells::LightCells;
use super::order::neighbours_first;
use super::prediction::{Cell, Prediction};
use super::settings::CoherenceSettings;
use super::statistics::{CoherenceCounters, CoherenceStatistics};
use crate::light_mean::LightMean;

/// Light that is as good as none, or as all: no more than what a picture of 8 bits
/// can show.
const SLIGHT: f32 = 1.0 / 512.0;

/// Steps from receiver to receiver that are longer than the usual one by this factor
/// are leaps, over which shadows of small occluders are lost.
const LONG_STEP: f64 = 4.0;

/// Coherent sampling of an area light over any tracer (Agrawala et al. 2000, §5.2).
///
/// The light is a grid of cells, each with a jittered sample. What a receiver sees
/// of them is predicted from the blockers that the receivers before it met, seen
/// from where it lies; traced are the cells at the light's border and where the
/// prediction changes, and those around every wrong prediction. Cells that are
/// neither clear nor blocked are always traced. Of blockers that lie inside the
/// light's outline for every receiver before, nothing is known ("missed blockers"),
/// nor of holes narrower than a cell ("missed holes"): they shrink with the
/// distance of receivers and the size of cells. After a step that is long for the
/// receivers at hand (over 4 times their median step) every cell is traced.
///
/// [`LightVisibility::visibilities`] takes receivers in an order of their own that
/// keeps neighbours together, and answers as if there were no others: the same
/// points and seeds give the same values, in whatever order. Of a tracer that does not
/// tell where its rays are blocked, the cells that were blocked before are
/// predicted to be so again.
///
/// O(rays) for traced rays, and O(cells + blockers) a receiver besides; at most nine
/// blockers a cell are kept.
///
/// ```
/// use std::convert::Infallible;
///
/// use dsm_core::detail::Occlusion;
/// use dsm_core::{AreaLight, Facing, LightVisibility, OcclusionTracer, ShadedPoint};
/// use dsm_trace::detail::{CoherenceSettings, CoherentShadow};
/// use glam::DVec3;
///
/// /// A half plane at y = 1, where x < 0.
/// struct Edge;
///
/// impl OcclusionTracer for Edge {
///     type Value = f32;
///     type Error = Infallible;
///
///     fn transmittance(&self, from: DVec3, to: DVec3, _: f64) -> Result<f32, Infallible> {
///         Ok(if from.lerp(to, (1.0 - from.y) / (to.y - from.y)).x < 0.0 { 0.0 } else { 1.0 })
///     }
///
///     fn occlusions(
///         &self,
///         receiver: &ShadedPoint,
///         targets: &[(DVec3, f64)],
///         found: &mut Vec<Occlusion<f32>>,
///     ) -> Result<(), Infallible> {
///         for &(light, time) in targets {
///             let from = receiver.position;
///             let transmittance = self.transmittance(from, light, time)?;
///             let met = from.lerp(light, (1.0 - from.y) / (light.y - from.y));
///             found.push(Occlusion { transmittance, blocker: (met.x < 0.0).then_some(met) });
///         }
///         Ok(())
///     }
/// }
///
/// let light = AreaLight::rectangle(DVec3::Y * 4.0, DVec3::X, DVec3::Z);
/// let points: Vec<ShadedPoint> = (0..100)
///     .map(|i| DVec3::new(0.01 * f64::from(i) - 0.5, 0.0, 0.0))
///     .map(|position| ShadedPoint { position, facing: Facing::Light, seed: 1 })
///     .collect();
/// let shadow = CoherentShadow::new(Edge, CoherenceSettings::new(16));
/// let mut values = Vec::new();
/// shadow.visibilities(&points, &light, &mut values)?;
/// assert!((values[0] - 0.0).abs() < 0.01 && (values[50] - 0.5).abs() < 0.04);
/// let counted = shadow.statistics();
/// assert!(counted.rays < counted.cells * 3 / 5);
/// # Ok::<(), Infallible>(())
/// ```
#[derive(Debug)]
pub struct CoherentShadow<O> {
    tracer: O,
    settings: CoherenceSettings,
    counters: CoherenceCounters,
}

impl<O: OcclusionTracer> CoherentShadow<O> {
    /// Coherent sampling by the rays of `tracer`.
    #[must_use]
    pub fn new(tracer: O, settings: CoherenceSettings) -> Self {
        Self { tracer, settings, counters: CoherenceCounters::default() }
    }

    /// The tracer.
    #[must_use]
    pub const fn tracer(&self) -> &O {
        &self.tracer
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &CoherenceSettings {
        &self.settings
    }

    /// Counts of the receivers so far.
    #[must_use]
    pub fn statistics(&self) -> CoherenceStatistics {
        self.counters.get()
    }

    fn sampling(&self, light: &AreaLight) -> Sampling<'_, O> {
        // A point has no cells.
        let side = if light.shape() == LightShape::Point { 1 } else { self.settings.side() };
        Sampling {
            shadow: self,
            cells: LightCells::new(side),
            prediction: Prediction::new(side),
            blockers: Blockers::default(),
            before: None,
            longest_step: 0.0,
            is_fresh: true,
            targets: Vec::new(),
            found: Vec::new(),
            lights: Vec::new(),
            counted: CoherenceStatistics::default(),
        }
    }
}

impl<O: OcclusionTracer> LightVisibility for CoherentShadow<O> {
    type Value = O::Value;
    type Error = O::Error;

    /// Traces every cell: there are no neighbours.
    fn visibility(
        &self,
        receiver: DVec3,
        light: &AreaLight,
        seed: u64,
    ) -> Result<O::Value, O::Error> {
        let point = ShadedPoint { position: receiver, facing: Facing::Light, seed };
        self.sampling(light).visibility(&point, light)
    }

    fn visibilities(
        &self,
        points: &[ShadedPoint],
        light: &AreaLight,
        values: &mut Vec<O::Value>,
    ) -> Result<(), O::Error> {
        let (mut order, mut sampling) = (Vec::new(), self.sampling(light));
        neighbours_first(points, &mut order);
        sampling.longest_step = LONG_STEP * usual_step(points, &order);
        let mut found = vec![O::Value::CLEAR; points.len()];
        for index in order {
            found[index] = sampling.visibility(&points[index], light)?;
        }
        values.append(&mut found);
        Ok(())
    }
}

/// A run of receivers, each sampled with what is known from those before.
pub(super) struct Sampling<'a, O: OcclusionTracer> {
    shadow: &'a CoherentShadow<O>,
    cells: LightCells,
    prediction: Prediction,
    blockers: Blockers,
    before: Option<DVec3>,
    /// The distance of receivers beyond which nothing is predicted.
    longest_step: f64,
    /// Nothing was predicted.
    is_fresh: bool,
    targets: Vec<(DVec3, f64)>,
    found: Vec<Occlusion<O::Value>>,
    /// What is left of the light of each cell that was traced.
    lights: Vec<O::Value>,
    counted: CoherenceStatistics,
}

impl<O: OcclusionTracer> Sampling<'_, O> {
    fn visibility(&mut self, point: &ShadedPoint, light: &AreaLight) -> Result<O::Value, O::Error> {
        self.cells.sample(point.position, light, point.seed);
        self.predict(point.position, light);
        self.lights.clear();
        self.lights.resize(self.cells.targets().len(), O::Value::CLEAR);
        self.counted.receivers += 1;
        self.counted.cells += self.lights.len() as u64;
        while !self.prediction.todo().is_empty() {
            self.trace(point)?;
        }
        let mut mean = LightMean::new();
        for (index, cell) in self.prediction.cells().iter().enumerate() {
            mean.add(match cell {
                _ if self.prediction.is_traced(index) => self.lights[index],
                Cell::Blocked => O::Value::BLOCKED,
                Cell::Clear | Cell::Partial => O::Value::CLEAR,
            });
        }
        self.before = Some(point.position);
        Ok(mean.of(self.lights.len() as u32))
    }

    /// Predicts the cells, if a receiver near enough went before.
    fn predict(&mut self, receiver: DVec3, light: &AreaLight) {
        let settings = &self.shadow.settings;
        let reach = settings.reach() * receiver.distance(light.centre());
        let reach = reach.min(self.longest_step);
        let is_near = self.before.is_some_and(|before| before.distance(receiver) <= reach);
        let is_known = settings.predicts() && is_near;
        if !is_known {
            self.blockers.clear();
        }
        self.prediction.clear();
        let (cells, prediction) = (&self.cells, &mut self.prediction);
        self.blockers.project(receiver, light, cells, settings.covers(), prediction);
        if is_known {
            self.prediction.trace_edges();
        } else {
            self.prediction.trace_all();
            self.counted.fresh += 1;
        }
        self.is_fresh = !is_known;
    }

    /// Traces the cells that are uncertain now.
    fn trace(&mut self, point: &ShadedPoint) -> Result<(), O::Error> {
        let todo = self.prediction.todo();
        self.targets.clear();
        self.targets.extend(todo.iter().map(|&cell| self.cells.targets()[cell]));
        self.found.clear();
        self.shadow.tracer.occlusions(point, &self.targets, &mut self.found)?;
        self.counted.rays += todo.len() as u64;
        for ((&cell, met), &(target, _)) in todo.iter().zip(&self.found).zip(&self.targets) {
            self.lights[cell] = met.transmittance;
            let kind = kind_of(met.transmittance);
            if kind != Cell::Clear {
                // Nearest to the light if unknown: a neighbour then sees the same cell so.
                self.blockers.push(Blocker { point: met.blocker.unwrap_or(target), kind });
            }
        }
        let traced = self.found.iter().map(|met| kind_of(met.transmittance));
        let wrong = self.prediction.settle(traced);
        self.counted.mispredicted += if self.is_fresh { 0 } else { wrong };
        Ok(())
    }
}

impl<O: OcclusionTracer> Drop for Sampling<'_, O> {
    fn drop(&mut self) {
        self.shadow.counters.add(&self.counted);
    }
}

/// The median distance of receivers that follow each other; 0 if there are none.
fn usual_step(points: &[ShadedPoint], order: &[usize]) -> f64 {
    let step = |pair: &[usize]| points[pair[0]].position.distance(points[pair[1]].position);
    let mut steps: Vec<f64> = order.windows(2).map(step).filter(|step| step.is_finite()).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

fn kind_of<T: Transmittance>(light: T) -> Cell {
    let is = |test: fn(f32) -> bool| (0..T::CHANNELS).all(|channel| test(light.channel(channel)));
    if is(|part| part <= SLIGHT) {
        Cell::Blocked
    } else if is(|part| part >= 1.0 - SLIGHT) {
        Cell::Clear
    } else {
        Cell::Partial
    }
}
