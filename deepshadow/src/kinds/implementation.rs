//! The implementation of each kind.

use super::attenuation::Attenuation;
use super::deep::Deep;
use super::fragments::Fragments;
use super::layers::Layers;
use super::mtsm::Mtsm;
use super::prefiltered::Prefiltered;
use super::shadow_kind::ShadowKind;
use super::views::Views;
use crate::kind::{Kind, KindId};

/// The implementation of `kind`.
pub(crate) const fn implementation(kind: Kind) -> &'static dyn ShadowKind {
    match kind.id() {
        KindId::Attenuation => &Attenuation,
        KindId::Deep => &Deep,
        KindId::Fragments => &Fragments,
        KindId::Layers => &Layers,
        KindId::Mtsm => &Mtsm,
        KindId::Prefiltered => &Prefiltered,
        KindId::Views => &Views,
    }
}
