//! Curves and points as strands.

use glam::{DVec3, Vec3};

use super::attributes::{Primvar, Spread, broken, indices};
use super::cubic::{Basis, Blend, Layout, Wrap, evaluate};
use super::{Geometry, Reader};
use crate::error::{Error, Result};
use crate::load::MAX_PRIMITIVES;
use crate::load::usd::stage::Prim;

/// A strand may lie this part of its radius beside its curve.
const TOLERANCE: f64 = 1.0 / 32.0;
/// Pieces that a segment of a curve becomes at most.
const MOST_PIECES: usize = 32;

/// Strands so far.
#[derive(Default)]
struct Strands {
    points: Vec<Vec3>,
    radii: Vec<f32>,
    opacities: Vec<f32>,
    lengths: Vec<u32>,
}

impl Strands {
    fn add(&mut self, point: DVec3, width: f64, opacity: Option<f64>) -> Result<()> {
        let count = self.points.len() as u64 + 1;
        if count > MAX_PRIMITIVES {
            return Err(Error::TooLarge { what: "points", count, limit: MAX_PRIMITIVES });
        }
        self.points.push(point.as_vec3());
        self.radii.push((width.max(0.0) / 2.0) as f32);
        self.opacities.extend(opacity.map(|value| value.clamp(0.0, 1.0) as f32));
        Ok(())
    }

    fn into_geometry(self) -> Geometry {
        let Self { points, radii, opacities, lengths } = self;
        Geometry::Strands { points, radii, opacities, lengths }
    }
}

/// A primvar along one curve.
#[derive(Clone, Copy)]
struct Along<'a> {
    spread: Spread,
    /// The curve's part of the data.
    data: &'a [f64],
}

impl<'a> Along<'a> {
    fn at(&self, layout: &Layout, segment: usize) -> Option<[f64; 4]> {
        match self.spread {
            Spread::Constant | Spread::Uniform => self.data.first().map(|&value| [value; 4]),
            Spread::Vertex => {
                let (data, count) = (self.data, layout.count);
                (data.len() == count).then(|| layout.bezier(segment, |at| data[at]))
            }
            Spread::Varying | Spread::FaceVarying => {
                let from = *self.data.get(segment)?;
                let to = *self.data.get((segment + 1) % self.data.len())?;
                Some([0.0, 1.0, 2.0, 3.0].map(|third| from + (to - from) * third / 3.0))
            }
        }
    }
}

/// The parts of a primvar that belong to each curve; none if it has another number of
/// values. Closed linear curves may have the value of their first point once more, as
/// the standard's own library counts.
fn split<'a>(primvar: &'a Primvar, layouts: &[Layout]) -> Option<Vec<Along<'a>>> {
    let spread = primvar.spread;
    if spread == Spread::Constant {
        let data = primvar.data.get(..1)?;
        return Some(vec![Along { spread, data }; layouts.len()]);
    }
    let length = |layout: &Layout, is_closed: bool| match spread {
        Spread::Constant => 0,
        Spread::Uniform => 1,
        Spread::Vertex => layout.count,
        Spread::Varying | Spread::FaceVarying => layout.varying() + usize::from(is_closed),
    };
    let total = |is_closed| layouts.iter().map(|layout| length(layout, is_closed)).sum::<usize>();
    let may_close = matches!(spread, Spread::Varying | Spread::FaceVarying)
        && layouts
            .first()
            .is_some_and(|layout| (layout.basis, layout.wrap) == (Basis::Linear, Wrap::Periodic));
    let is_closed = match primvar.data.len() {
        count if count == total(false) => false,
        count if may_close && count == total(true) => true,
        _ => return None,
    };
    let mut rest = &primvar.data[..];
    let mut take = |layout: &Layout| {
        let (data, after) = rest.split_at(length(layout, is_closed));
        rest = after;
        Along { spread, data }
    };
    Some(layouts.iter().map(&mut take).collect())
}

impl Reader<'_, '_> {
    /// A curve's strands. Cubic segments become as many straight pieces as keep them
    /// within 1/32 of the radius, but 32.
    pub(super) fn curves(&mut self, prim: &Prim, opacity: Option<&Primvar>) -> Result<Geometry> {
        let points = self.vectors(prim, "points")?.unwrap_or_default();
        let counts = match self.numbers(prim, "curveVertexCounts")? {
            Some(counts) => indices(prim, "curveVertexCounts", &counts)?,
            None => Vec::new(),
        };
        let kind = self.word(prim, "type", "cubic")?;
        let basis = self.word(prim, "basis", "bezier")?;
        let basis = match (kind.as_str(), basis.as_str()) {
            ("linear", _) => Basis::Linear,
            ("cubic", "bezier") => Basis::Bezier,
            ("cubic", "bspline") => Basis::BSpline,
            ("cubic", "catmullRom") => Basis::CatmullRom,
            _ => return Err(broken(prim, format!("{kind} curves of basis {basis} are not read"))),
        };
        let wrap = match self.word(prim, "wrap", "nonperiodic")?.as_str() {
            "nonperiodic" => Wrap::Nonperiodic,
            "periodic" => Wrap::Periodic,
            "pinned" => Wrap::Pinned,
            wrap => return Err(broken(prim, format!("curves that wrap {wrap} are not read"))),
        };
        let total: u64 = counts.iter().map(|&count| u64::from(count)).sum();
        if total != points.len() as u64 {
            let reason = format!("its curves have {total} points, and {} are there", points.len());
            return Err(broken(prim, reason));
        }
        if self.numbers(prim, "normals")?.is_some_and(|normals| !normals.data.is_empty()) {
            let line = format!("{}: its ribbons face the light, whatever its normals", prim.path);
            self.stage.warnings.add(line);
        }
        let layouts: Vec<Layout> = counts
            .iter()
            .filter(|&&count| count > 0)
            .map(|&count| Layout { basis, wrap, count: count as usize })
            .collect();
        let widths = self.widths(prim)?;
        let Some(widths) = split(&widths, &layouts) else {
            let reason = format!("{} widths do not fit its curves", widths.data.len());
            return Err(broken(prim, reason));
        };
        let opacity = opacity.filter(|opacity| opacity.spread != Spread::Constant);
        let opacities = opacity.and_then(|opacity| split(opacity, &layouts));
        if opacity.is_some() && opacities.is_none() {
            let line = format!("{}: opacities that do not fit its curves are left out", prim.path);
            self.stage.warnings.add(line);
        }
        let mut strands = Strands::default();
        let mut rest = &points[..];
        for (index, layout) in layouts.iter().enumerate() {
            let (own, after) = rest.split_at(layout.count);
            rest = after;
            let opacity = opacities.as_ref().map(|opacities| opacities[index]);
            add_curve(&mut strands, layout, own, widths[index], opacity)?;
        }
        Ok(strands.into_geometry())
    }

    /// Points as strands of no length: discs that face the ray.
    pub(super) fn points(&mut self, prim: &Prim, opacity: Option<&Primvar>) -> Result<Geometry> {
        let points = self.vectors(prim, "points")?.unwrap_or_default();
        let widths = self.widths(prim)?;
        // To points all spreads but one value for all are the same.
        let spread = |primvar: &Primvar| match primvar.spread {
            Spread::Constant | Spread::Uniform => !primvar.data.is_empty(),
            _ => primvar.data.len() == points.len(),
        };
        let value = |primvar: &Primvar, index: usize| match primvar.spread {
            Spread::Constant | Spread::Uniform => primvar.data[0],
            _ => primvar.data[index],
        };
        if !points.is_empty() && !spread(&widths) {
            let reason = format!("{} widths for {} points", widths.data.len(), points.len());
            return Err(broken(prim, reason));
        }
        let opacity = opacity.filter(|opacity| opacity.spread != Spread::Constant);
        let fits = opacity.is_none_or(&spread);
        if !fits {
            let line = format!("{}: opacities that do not fit its points are left out", prim.path);
            self.stage.warnings.add(line);
        }
        let opacity = opacity.filter(|_| fits);
        let mut strands = Strands::default();
        for (index, &point) in points.iter().enumerate() {
            for _ in 0..2 {
                let opacity = opacity.map(|opacity| value(opacity, index));
                strands.add(point.into(), value(&widths, index), opacity)?;
            }
            strands.lengths.push(2);
        }
        Ok(strands.into_geometry())
    }
}

fn add_curve(
    strands: &mut Strands,
    layout: &Layout,
    points: &[[f64; 3]],
    widths: Along<'_>,
    opacities: Option<Along<'_>>,
) -> Result<()> {
    let start = strands.points.len();
    for segment in 0..layout.segments() {
        let curve = layout.bezier(segment, |at| DVec3::from(points[at]));
        let Some(widths) = widths.at(layout, segment) else { continue };
        let opacities = opacities.and_then(|opacities| opacities.at(layout, segment));
        let pieces = match layout.basis {
            Basis::Linear => 1,
            _ => pieces(curve, widths),
        };
        let first = usize::from(strands.points.len() > start);
        for piece in first..=pieces {
            let part = piece as f64 / pieces as f64;
            let opacity = opacities.map(|opacities| evaluate(opacities, part));
            strands.add(evaluate(curve, part), evaluate(widths, part), opacity)?;
        }
    }
    let added = strands.points.len() - start;
    if added > 0 {
        strands.lengths.push(added as u32);
    }
    Ok(())
}

/// Pieces of equal time that stay near a segment. A chord of n pieces is off by at most
/// |p″| / 8n², and the second derivative is largest at an end. Widths count as places
/// do.
fn pieces(curve: [DVec3; 4], widths: [f64; 4]) -> usize {
    let bend = |[a, b, c]: [DVec3; 3]| DVec3::blend([(1.0, a), (-2.0, b), (1.0, c)]).length();
    let [a, b, c, d] = curve;
    let [u, v, w, x] = widths;
    let curved = 6.0 * bend([a, b, c]).max(bend([b, c, d]));
    let swelling = 3.0 * (u - 2.0 * v + w).abs().max((v - 2.0 * w + x).abs());
    let radius = widths.into_iter().fold(0.0, f64::max) / 2.0;
    let pieces = ((curved + swelling) / (8.0 * radius * TOLERANCE)).sqrt().ceil();
    if pieces.is_finite() { pieces.clamp(1.0, MOST_PIECES as f64) as usize } else { 1 }
}
