//! The shape and size of a light, wherever it stands.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::light::AreaLight;

/// The shape of a light.
///
/// ```
/// use dsm_core::LightExtent;
/// use dsm_core::detail::LightShape;
///
/// assert_eq!(LightExtent::sphere(0.5).shape(), LightShape::Sphere);
/// assert_eq!(LightShape::Sphere.name(), "sphere");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum LightShape {
    /// A point.
    Point,
    /// A rectangle, spanned by the half axes.
    Rectangle,
    /// An ellipse, spanned by the half axes: a disk if they are equally long.
    Disk,
    /// A sphere as long as the half axes in radius.
    Sphere,
}

impl LightShape {
    /// The shape's name, as scene files and headers spell it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Rectangle => "rectangle",
            Self::Disk => "disk",
            Self::Sphere => "sphere",
        }
    }
}

/// The shape and size of a light, along the right and up axes of the camera at its
/// place. Headers of maps keep the size in `f32`.
///
/// ```
/// use dsm_core::LightExtent;
///
/// let panel = LightExtent::rectangle([0.5, 0.25]);
/// assert_eq!(panel.size(), [0.5, 0.25]);
/// assert_eq!(LightExtent::disk(0.25).size(), [0.5; 2]);
/// // Of size 0 any light is a point.
/// assert_eq!(panel.with_size([0.0; 2]), Some(LightExtent::POINT));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Stored", into = "Stored")]
pub struct LightExtent {
    shape: LightShape,
    size: [f64; 2],
}

impl LightExtent {
    /// A point.
    pub const POINT: Self = Self { shape: LightShape::Point, size: [0.0; 2] };

    /// A rectangle, by its full width and height in scene units.
    #[must_use]
    pub const fn rectangle(size: [f64; 2]) -> Self {
        Self { shape: LightShape::Rectangle, size }
    }

    /// A disk that faces where the camera looks, by its radius in scene units.
    #[must_use]
    pub const fn disk(radius: f64) -> Self {
        Self { shape: LightShape::Disk, size: [2.0 * radius; 2] }
    }

    /// A sphere, by its radius in scene units.
    #[must_use]
    pub const fn sphere(radius: f64) -> Self {
        Self { shape: LightShape::Sphere, size: [2.0 * radius; 2] }
    }

    /// A light of any shape, by its full width and height: an ellipse for a disk of
    /// two diameters.
    pub(crate) const fn of_shape(shape: LightShape, size: [f64; 2]) -> Self {
        Self { shape, size }
    }

    /// The light with another full width and height: of size 0 any light is a
    /// point, and a point of another size becomes a rectangle. `None` for a disk or
    /// a sphere that would not be as high as wide.
    #[must_use]
    pub fn with_size(self, size: [f64; 2]) -> Option<Self> {
        match self.shape {
            _ if size == [0.0; 2] => Some(Self::POINT),
            LightShape::Point | LightShape::Rectangle => Some(Self::rectangle(size)),
            LightShape::Disk | LightShape::Sphere => {
                (size[0] == size[1]).then_some(Self { size, ..self })
            }
        }
    }

    /// The shape.
    #[must_use]
    pub const fn shape(self) -> LightShape {
        self.shape
    }

    /// Full width and height in scene units: of a disk or a sphere the diameter, of
    /// a point 0.
    #[must_use]
    pub const fn size(self) -> [f64; 2] {
        self.size
    }

    /// The light in the world: at `centre`, along these unit axes.
    #[must_use]
    pub fn placed(self, centre: DVec3, [right, up]: [DVec3; 2]) -> AreaLight {
        let [width, height] = self.size.map(|size| size / 2.0);
        match self.shape {
            LightShape::Point => AreaLight::point(centre),
            LightShape::Rectangle => AreaLight::rectangle(centre, right * width, up * height),
            LightShape::Disk => AreaLight::disk(centre, right * width, up * height),
            LightShape::Sphere => AreaLight::sphere(centre, width),
        }
    }
}

/// What headers keep of an extent.
#[derive(Serialize, Deserialize)]
struct Stored {
    shape: LightShape,
    size: [f32; 2],
}

impl From<Stored> for LightExtent {
    fn from(Stored { shape, size }: Stored) -> Self {
        Self { shape, size: size.map(f64::from) }
    }
}

impl From<LightExtent> for Stored {
    fn from(LightExtent { shape, size }: LightExtent) -> Self {
        Self { shape, size: size.map(|size| size as f32) }
    }
}
