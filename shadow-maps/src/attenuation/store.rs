//! Kind `attenuation`: layered attenuation maps in `.dsm` files, as
//! `docs/format/dsm-1.md`, section 13, defines it.

use dsm_core::Transmittance;
use dsm_io::detail::{EncodedTile, Level, MapKind, MapTile, PixelValue, Result, StoredTile};
use dsm_io::{Codec, Error, MapSummary, Metadata, Packing, PixelContents};

use super::keys::AttenuationKeys;
use crate::prefilter::lists::{FragmentLists, ListWords};
use crate::prefilter::store::{encode, lists};

/// The kind `attenuation`: the layers of every texel that some point of a light sees, each
/// with the share of the light that it sees.
///
/// ```no_run
/// use dsm_io::Limits;
/// use dsm_io::detail::KindReader;
/// use shadow_maps::detail::Attenuation;
///
/// let reader = KindReader::<Attenuation>::open("leaves.dsm", &Limits::default())?;
/// println!("{} points of the light", reader.keys().light_samples);
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attenuation;

/// What the lists are called in messages.
const WORDS: ListWords = ListWords {
    range: "attenuations must lie in [0, 1]",
    nothing: "a layer that sees no light is none",
};

impl MapKind for Attenuation {
    const NAME: &'static str = "attenuation";
    const TITLE: &'static str = "an attenuation map";

    type Keys = AttenuationKeys;
    type Tile<T: Transmittance> = FragmentLists<T>;

    fn has_errors(_: &AttenuationKeys) -> bool {
        false
    }

    fn check(metadata: &Metadata, keys: &AttenuationKeys) -> Result<()> {
        let is_exact = metadata.info.tolerance.epsilon() <= 0.0;
        let inexact = (!is_exact).then_some("maps of this kind have a tolerance of 0");
        match keys.broken_rule().or(inexact) {
            Some(rule) => Err(Error::Metadata(rule.to_owned())),
            None => Ok(()),
        }
    }

    fn check_levels(levels: &[Level], _: &AttenuationKeys) -> Result<()> {
        if levels.len() == 1 {
            return Ok(());
        }
        Err(Error::Metadata("an attenuation map has one level".to_owned()))
    }

    fn encode<T: Transmittance>(
        tile: &FragmentLists<T>,
        codec: Codec,
        packing: Packing,
    ) -> Result<EncodedTile> {
        if codec != Codec::Exact {
            return Err(Error::Setting("attenuation maps are stored exactly".into()));
        }
        encode(tile, packing)
    }

    fn empty<T: Transmittance>(size: [u32; 2], _: &AttenuationKeys) -> Result<FragmentLists<T>> {
        Ok(FragmentLists::empty(size))
    }

    fn decode<T: Transmittance>(
        stored: StoredTile<'_>,
        _: &AttenuationKeys,
    ) -> Result<FragmentLists<T>> {
        lists(stored, &WORDS)
    }

    fn summarize<T: Transmittance>(tile: &FragmentLists<T>, summary: &mut MapSummary) {
        let lengths = tile.starts().windows(2).map(|pair| u64::from(pair[1] - pair[0]));
        let empty = summary.add_lists("layers", "max_layers_per_pixel", lengths);
        summary.add("empty_pixels", empty);
    }

    fn contents<T: Transmittance>(tile: &FragmentLists<T>, pixel: usize) -> PixelContents {
        let mut contents = PixelContents::new("layers", &["depth", "attenuation"]);
        let list = tile.list(pixel);
        for (&w, &share) in list.w.iter().zip(list.opacities) {
            let depth = w.recip().min(f32::MAX);
            contents.push([PixelValue::Number(depth), PixelValue::light(share)]);
        }
        contents
    }
}

impl<T: Transmittance> MapTile for FragmentLists<T> {
    #[inline]
    fn size(&self) -> [u32; 2] {
        self.size()
    }

    fn bytes(&self) -> u64 {
        let columns =
            size_of_val(self.starts()) + size_of_val(self.w()) + size_of_val(self.opacities());
        columns as u64
    }
}
