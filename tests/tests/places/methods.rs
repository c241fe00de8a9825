//! Every kind of map in a file, and every method that reads it.

use std::ops::ControlFlow;
use std::sync::Arc;

use deepshadow::detail::{PlainShadow, Result, plain_shadow};
use deepshadow::visibility::Bias;
use deepshadow::{
    AttenuationMethod, Bake, FarTable, FilterMethod, Kind, Method as MapMethod, PcfMethod,
    PrefilterMethod, Query, Shadow, ShadowMap, TraceMethod, bake,
};
use dsm_core::{Filter, FilterShape, Footprint, Tolerance};
use dsm_scene::{Scene, TracedScene};
use dsm_testkit::{Agreement, Trial};

use crate::scene::{misty, solid};

/// Width and height of maps.
pub(crate) const SIZE: u32 = 48;

/// Shadow rays and taps of a point.
const RAYS: u32 = 16;

/// How shadows are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    Reference,
    /// Lookups in a deep map.
    Deep,
    /// Taps in a plain map.
    Plain,
    /// Fragments traced, one by one.
    Fragments,
    /// Fragments traced, far ones by their optical depth.
    FarTable,
    /// Layers traced.
    Layers,
    /// Layers filtered over the light's outline.
    LayersFiltered,
    /// Runs of layers traced.
    Mtsm,
    /// Runs of layers filtered over the light's outline.
    MtsmFiltered,
    /// The first runs looked up like a deep map.
    MtsmLookup,
    /// Fragments merged by filters, looked up.
    Prefiltered,
    /// What places see of the light, of one pixel each.
    Attenuation,
    /// The same, of four.
    AttenuationBilinear,
    /// Several depth images traced.
    Views,
}

impl Method {
    pub(crate) const ALL: [Self; 14] = [
        Self::Reference,
        Self::Deep,
        Self::Plain,
        Self::Fragments,
        Self::FarTable,
        Self::Layers,
        Self::LayersFiltered,
        Self::Mtsm,
        Self::MtsmFiltered,
        Self::MtsmLookup,
        Self::Prefiltered,
        Self::Attenuation,
        Self::AttenuationBilinear,
        Self::Views,
    ];

    /// What it is tried on: with media where its map holds them.
    pub(crate) fn scene(self) -> Scene {
        match self {
            Self::Layers
            | Self::LayersFiltered
            | Self::Prefiltered
            | Self::Attenuation
            | Self::AttenuationBilinear
            | Self::Views => solid(),
            _ => misty(),
        }
    }

    /// How closely answers agree. Optical depths of media are within 6 · 10⁻⁶ of the
    /// truth in each cell of voxels, cut in more or fewer pieces as rounding has it.
    pub(crate) fn agreement(self) -> Agreement {
        match self {
            Self::Mtsm | Self::MtsmFiltered | Self::MtsmLookup | Self::Deep | Self::Fragments => {
                Agreement::default().with_tolerance(1.0 / f64::from(1 << 16))
            }
            // A ray may pass the edge of a floor by less than depths in `f32` are rounded by.
            Self::Views => Agreement::default().with_strays(0.005),
            _ => Agreement::default(),
        }
    }

    /// The kind of map that files hold, and the method that asks it.
    fn of_map(self) -> Option<(&'static str, MapMethod)> {
        // Under a tent, so that answers do not jump between pixels.
        let tent = Filter::new(FilterShape::Tent, 3.0).map(Footprint::Isotropic);
        let footprint = tent.unwrap_or(Footprint::Point);
        let filter = FilterMethod { footprint, bias: Bias::Auto, ..FilterMethod::POINT };
        let trace = TraceMethod::new(RAYS);
        Some(match self {
            Self::Reference | Self::Plain => return None,
            Self::Deep => ("deep", filter.into()),
            Self::Fragments => ("fragments", trace.with_far_table(FarTable::Off).into()),
            Self::FarTable => ("fragments", trace.with_far_table(FarTable::On).into()),
            Self::Layers => ("layers", trace.into()),
            Self::LayersFiltered => ("layers", PcfMethod::new(RAYS).into()),
            Self::Mtsm => ("mtsm", trace.into()),
            Self::MtsmFiltered => ("mtsm", PcfMethod::new(RAYS).into()),
            Self::MtsmLookup => ("mtsm", filter.into()),
            Self::Prefiltered => ("prefiltered", PrefilterMethod::new().into()),
            Self::Views => ("views", trace.into()),
            Self::Attenuation => ("attenuation", AttenuationMethod::new().into()),
            Self::AttenuationBilinear => {
                ("attenuation", AttenuationMethod::new().with_bilinear(true).into())
            }
        })
    }

    /// Makes it of a placed scene, from a file where there is a map that files hold.
    pub(crate) fn make(self, scene: &Scene, trial: &Trial) -> Result<Shadow> {
        let Some((kind, method)) = self.of_map() else {
            if self == Self::Reference {
                return Shadow::reference(Arc::new(TracedScene::new(scene)?), scene, RAYS);
            }
            let mut settings = PlainShadow::new(RAYS).with_width(2.0);
            (settings.resolution, settings.samples) = ([SIZE; 2], 4);
            return plain_shadow(scene, &scene.light, &settings);
        };
        let mut settings = Bake::new([SIZE; 2])?.with_kind(Kind::named(kind).unwrap());
        settings.tile_size = trial.tile_size;
        if kind == "deep" {
            settings = settings.with_samples(4).with_seed(1);
        }
        if ["deep", "fragments", "mtsm"].contains(&kind) {
            settings = settings.with_tolerance(Tolerance::EXACT);
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.dsm");
        bake(scene, &scene.light, &settings, &path, |_| ControlFlow::Continue(()))?;
        ShadowMap::open(&path)?.shadow(&Query::new().with_method(method))
    }
}
