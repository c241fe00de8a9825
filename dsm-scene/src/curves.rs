//! Strands of hair, fur or grass.

use glam::Vec3;

use crate::bounds::Bounds;
use crate::error::{Error, Place, Result};
use crate::mesh::check_point;

/// Strands: chains of segments with a radius at every point.
///
/// A segment is a ribbon that faces the ray, round at its ends. A ray meets a strand
/// once for each stretch of it that lies within the radius of the ray, interpolated
/// between points: once a crossing, however the strand is cut into segments. Segments
/// of radius 0 are never met.
///
/// ```
/// use dsm_scene::Curves;
/// use glam::Vec3;
///
/// // A strand of three points that gets thinner.
/// let points = vec![Vec3::ZERO, Vec3::Y, Vec3::Y * 2.0];
/// let strand = Curves::new(points, vec![0.25, 0.125, 0.0], [3])?;
/// assert_eq!((strand.strand_count(), strand.segments().len()), (1, 2));
/// assert_eq!(strand.segment(0)[1], (Vec3::Y, 0.125));
/// # Ok::<(), dsm_scene::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    points: Vec<Vec3>,
    radii: Vec<f32>,
    opacities: Vec<f32>,
    starts: Vec<u32>,
    segments: Vec<u32>,
}

impl Curves {
    /// Bytes of its columns.
    pub(crate) fn bytes(&self) -> u64 {
        let numbers =
            [self.radii.len(), self.opacities.len(), self.starts.len(), self.segments.len()];
        let numbers: usize = numbers.iter().sum();
        (size_of_val(&*self.points) + 4 * numbers) as u64
    }

    /// Strands of `lengths` points each, one after the other; strands of fewer
    /// than two points have no segments. One radius a point.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for coordinates that are not finite or beyond
    /// 1e18, radii that are negative or not finite, and columns that don't fit
    /// together; [`Error::TooLarge`] above 2³² points.
    pub fn new(
        points: Vec<Vec3>,
        radii: Vec<f32>,
        lengths: impl IntoIterator<Item = u32>,
    ) -> Result<Self> {
        if u32::try_from(points.len()).is_err() {
            let limit = u64::from(u32::MAX);
            return Err(Error::TooLarge { what: "points", count: points.len() as u64, limit });
        }
        if radii.len() != points.len() {
            return Err(Error::malformed(Place::Whole, "radii must be one per point"));
        }
        for (index, (&point, &radius)) in points.iter().zip(&radii).enumerate() {
            check_point(point, || Place::Point(index as u64))?;
            check_radius(radius, index)?;
        }
        let mut starts = vec![0];
        let mut segments = Vec::with_capacity(points.len());
        let mut end = 0_u64;
        for (strand, length) in lengths.into_iter().enumerate() {
            let start = end;
            end += u64::from(length);
            if end > points.len() as u64 {
                let reason = format!("it ends at point {end}, and there are {}", points.len());
                return Err(Error::malformed(Place::Strand(strand as u64), reason));
            }
            segments.extend(start as u32..(end.saturating_sub(1)).max(start) as u32);
            starts.push(end as u32);
        }
        if end != points.len() as u64 {
            let reason = format!("{} points belong to no strand", points.len() as u64 - end);
            return Err(Error::malformed(Place::Whole, reason));
        }
        Ok(Self { points, radii, opacities: Vec::new(), starts, segments })
    }

    /// The width of the thinnest strand, at its thickest place, in the curves' own
    /// space; `None` without segments of any width. O(points).
    #[must_use]
    pub fn finest_width(&self) -> Option<f32> {
        let strands = self.starts.windows(2).filter(|strand| strand[1] > strand[0] + 1);
        let widths = strands.map(|strand| {
            let radii = &self.radii[strand[0] as usize..strand[1] as usize];
            2.0 * radii.iter().copied().fold(0.0, f32::max)
        });
        widths.filter(|&width| width > 0.0).reduce(f32::min)
    }

    /// Sets the opacity at every point, in [0, 1].
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for another number of them, or one outside [0, 1].
    pub fn with_opacities(self, opacities: Vec<f32>) -> Result<Self> {
        if opacities.len() != self.points.len() {
            return Err(Error::malformed(Place::Whole, "opacities must be one per point"));
        }
        if let Some(index) = opacities.iter().position(|o| !(0.0..=1.0).contains(o)) {
            return Err(Error::malformed(
                Place::Point(index as u64),
                format!("opacity must lie in [0, 1], not {}", opacities[index]),
            ));
        }
        Ok(Self { opacities, ..self })
    }

    /// Sets the thickness of all strands to `diameter`.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for a diameter that is negative or not finite.
    pub fn with_thickness(mut self, diameter: f32) -> Result<Self> {
        check_radius(diameter / 2.0, 0)?;
        self.radii.fill(diameter / 2.0);
        Ok(self)
    }

    /// All points, strand after strand.
    #[must_use]
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// One radius a point.
    #[must_use]
    pub fn radii(&self) -> &[f32] {
        &self.radii
    }

    /// Number of strands.
    #[must_use]
    pub fn strand_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The first point of every segment; its second is the next one.
    #[must_use]
    pub fn segments(&self) -> &[u32] {
        &self.segments
    }

    /// The two ends of segment `index`, each with its radius.
    #[must_use]
    #[inline]
    pub fn segment(&self, index: usize) -> [(Vec3, f32); 2] {
        let first = self.segments[index] as usize;
        [first, first + 1].map(|point| (self.points[point], self.radii[point]))
    }

    /// True if segment `index` begins where the one before it ends.
    #[must_use]
    pub fn is_joined(&self, index: usize) -> bool {
        index > 0 && self.segments[index - 1] + 1 == self.segments[index]
    }

    /// The opacity `along` segment `index`, 0 at its first end and 1 at its
    /// second: 1 unless opacities were given.
    #[must_use]
    pub fn opacity(&self, index: usize, along: f32) -> f32 {
        let first = self.segments[index] as usize;
        match self.opacities.get(first..first + 2) {
            Some(&[a, b]) => a + (b - a) * along,
            _ => 1.0,
        }
    }

    /// The opacity of all strands, if it is the same everywhere.
    pub(crate) fn even_opacity(&self) -> Option<f32> {
        let first = self.opacities.first().copied().unwrap_or(1.0);
        self.opacities.iter().all(|&opacity| opacity == first).then_some(first)
    }

    /// The box around all strands, as thick as they are.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let ends = (0..self.segments.len()).flat_map(|index| self.segment(index));
        Bounds::of_balls(ends)
    }
}

fn check_radius(radius: f32, point: usize) -> Result<()> {
    if (0.0..=1e18).contains(&radius) {
        Ok(())
    } else {
        Err(Error::malformed(
            Place::Point(point as u64),
            format!("thickness must lie between 0 and 2e18, not {}", radius * 2.0),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: usize) -> Vec<Vec3> {
        (0..count).map(|x| Vec3::X * x as f32).collect()
    }

    #[test]
    fn strands_are_chains_of_segments() {
        let curves = Curves::new(points(7), vec![0.5; 7], [3, 0, 1, 3]).unwrap();
        assert_eq!(curves.segments(), [0, 1, 4, 5]);
        assert_eq!([0, 1, 2, 3].map(|index| curves.is_joined(index)), [false, true, false, true]);
        assert_eq!(curves.strand_count(), 4);
        assert_eq!(curves.segment(2), [(Vec3::X * 4.0, 0.5), (Vec3::X * 5.0, 0.5)]);
        assert_eq!(curves.bounds().min.x, -0.5);
        let curves = curves.with_thickness(0.2).unwrap();
        assert_eq!(curves.radii(), [0.1; 7]);
        let curves = curves.with_opacities((0..7).map(|x| x as f32 / 8.0).collect()).unwrap();
        assert_eq!(curves.opacity(3, 0.5), 5.5 / 8.0);
    }

    #[test]
    fn curves_no_scene_can_have_are_refused() {
        assert!(Curves::new(points(3), vec![0.5; 2], [3]).is_err());
        assert!(Curves::new(points(3), vec![0.5; 3], [4]).is_err());
        assert!(Curves::new(points(3), vec![0.5; 3], [2]).is_err());
        assert!(Curves::new(points(3), vec![0.5; 3], [3, u32::MAX, u32::MAX]).is_err());
        for odd in [-0.1, f32::NAN, f32::INFINITY] {
            assert!(Curves::new(points(2), vec![0.5, odd], [2]).is_err());
            let plain = Curves::new(points(2), vec![0.5; 2], [2]).unwrap();
            assert!(plain.clone().with_thickness(odd).is_err());
            assert!(plain.with_opacities(vec![0.5, odd]).is_err());
        }
        assert!(Curves::new(vec![Vec3::NAN; 2], vec![0.5; 2], [2]).is_err());
    }
}
