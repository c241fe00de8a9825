//! Names of kinds of map.

use std::fmt;

use dsm_scene::Scene;

use crate::query::method::Method;

/// A kind of map that can be baked and queried.
///
/// ```
/// use deepshadow::Kind;
///
/// assert_eq!(Kind::named("mtsm"), Some(Kind::MTSM));
/// assert_eq!(Kind::FRAGMENTS.name(), "fragments");
/// assert!(Kind::ALL.contains(&Kind::DEEP));
/// ```
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Kind(KindId);

/// The kinds, one for each implementation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum KindId {
    Attenuation,
    Deep,
    Fragments,
    Layers,
    Mtsm,
    Prefiltered,
    Views,
}

impl Kind {
    /// Deep shadow maps: a visibility function a pixel, compressed within a bound
    /// (Lokovic & Veach 2000).
    pub const DEEP: Self = Self(KindId::Deep);

    /// Maps of fragments: planes with coverage masks, for the shadows of area lights.
    pub const FRAGMENTS: Self = Self(KindId::Fragments);

    /// Multilayer depth maps: the first hits of every pixel's centre (Xie et al.
    /// 2007, §4.2).
    pub const LAYERS: Self = Self(KindId::Layers);

    /// Multilayer transparent shadow maps: runs of compressed layers with counts
    /// (Xie et al. 2007, §5).
    pub const MTSM: Self = Self(KindId::Mtsm);

    /// Prefiltered maps: fragments a texel, merged by wider and wider filters, whose soft
    /// shadows are looked up (Selgrad et al. 2014).
    pub const PREFILTERED: Self = Self(KindId::Prefiltered);

    /// Layered attenuation maps: the places that any point of a light sees, each with the
    /// share of the light that it sees (Agrawala et al. 2000, §4).
    pub const ATTENUATION: Self = Self(KindId::Attenuation);

    /// Depth images from several points of a light, which shadow rays are traced through
    /// (Agrawala et al. 2000, §5.1).
    pub const VIEWS: Self = Self(KindId::Views);

    /// All kinds.
    pub const ALL: &[Self] = &[
        Self::DEEP,
        Self::FRAGMENTS,
        Self::LAYERS,
        Self::MTSM,
        Self::PREFILTERED,
        Self::ATTENUATION,
        Self::VIEWS,
    ];

    /// The kind of this name, if there is one.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.name() == name)
    }

    /// The kind's name in headers and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self.0 {
            KindId::Attenuation => "attenuation",
            KindId::Deep => "deep",
            KindId::Fragments => "fragments",
            KindId::Layers => "layers",
            KindId::Mtsm => "mtsm",
            KindId::Prefiltered => "prefiltered",
            KindId::Views => "views",
        }
    }

    /// A line about the kind, as help texts print it.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self.0 {
            KindId::Attenuation => {
                "Layered attenuation maps: what each place sees of the light, for soft shadows by \
                 one lookup"
            }
            KindId::Deep => "Deep shadow maps: a visibility function a pixel",
            KindId::Fragments => "Maps of fragments: planes with coverage masks, and media",
            KindId::Layers => "Multilayer depth maps: the first hits of every pixel's centre",
            KindId::Mtsm => {
                "Multilayer transparent shadow maps: runs of compressed layers with counts"
            }
            KindId::Prefiltered => {
                "Prefiltered maps: fragments in levels of wider and wider filters, for soft \
                 shadows by lookup"
            }
            KindId::Views => "Depth images from several points of the light, traced",
        }
    }

    /// True of kinds whose pixels hold layers for area lights, as a ray through their
    /// middle at mid-shutter meets them; false of those that are filtered.
    #[must_use]
    pub const fn is_layered(self) -> bool {
        !matches!(self.0, KindId::Deep)
    }

    /// True of kinds with planes: they have far tables, and what a bound of layers cuts is
    /// one with the last that is kept.
    #[must_use]
    pub const fn has_planes(self) -> bool {
        matches!(self.0, KindId::Fragments)
    }

    /// True of kinds that are made of a map or a deep image, too
    /// ([`ShadowMap::prefilter`](crate::ShadowMap::prefilter)).
    #[must_use]
    pub const fn is_made_of_maps(self) -> bool {
        matches!(self.0, KindId::Prefiltered)
    }

    /// The width and height in pixels of a map that is baked where none are told; `None`
    /// where that follows the scene ([`Self::resolution_for`]).
    #[must_use]
    pub const fn resolution(self) -> Option<[u32; 2]> {
        match self.0 {
            KindId::Attenuation | KindId::Deep | KindId::Layers | KindId::Mtsm | KindId::Views => {
                Some([512; 2])
            }
            KindId::Prefiltered => Some([1024; 2]),
            KindId::Fragments => None,
        }
    }

    /// The width and height in pixels that suit a map of a scene: 512; of kind prefiltered
    /// 1024; of fragments 1024, as receivers lie next to what they show, unless a pixel where the scene is nearest
    /// to the light would be narrower than two of its finest strands: parts of a strand
    /// would shade each other. O(points of strands).
    ///
    /// ```
    /// use deepshadow::Kind;
    /// use deepshadow::scene::Scene;
    ///
    /// let scene = Scene::of_objects(Vec::new());
    /// assert_eq!(Kind::DEEP.resolution_for(&scene), [512, 512]);
    /// assert_eq!(Kind::FRAGMENTS.resolution_for(&scene), [1024, 1024]);
    /// ```
    #[must_use]
    pub fn resolution_for(self, scene: &Scene) -> [u32; 2] {
        let (coarse, fine) = ([512; 2], [1024; 2]);
        self.resolution().unwrap_or_else(|| {
            let pixel = scene.pixel_size(fine);
            let is_narrow = |(pixel, strand)| pixel < 2.0 * strand;
            if pixel.zip(scene.finest_strand()).is_some_and(is_narrow) { coarse } else { fine }
        })
    }

    pub(crate) const fn id(self) -> KindId {
        self.0
    }

    /// The kind that comes closest to rays through a scene, for a map that is
    /// queried by `method`: fragments, unless rules for layers were set. Lookups of
    /// prefiltered and of attenuation maps need such.
    #[must_use]
    pub fn for_area_lights(method: &Method) -> Self {
        if let Method::Prefilter(_) | Method::Hybrid(_) = method {
            return Self::PREFILTERED;
        }
        if let Method::Attenuation(_) = method {
            return Self::ATTENUATION;
        }
        let has_rules = matches!(method, Method::Trace(trace) if trace.has_layer_rules());
        let no_planes = has_rules || matches!(method, Method::Pcf(_));
        if no_planes { Self::MTSM } else { Self::FRAGMENTS }
    }
}

impl fmt::Debug for Kind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Kind({})", self.name())
    }
}
