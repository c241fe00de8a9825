//! Which channels are depth and opacity, where their names leave it open.

use crate::channel::ReadChannels;
use crate::selection::Selection;

/// Names of opacities, whatever their layer. (*Interpreting OpenEXR Deep Pixels* has
/// `AR`, `AG`, `AB`, the *Technical Introduction* `RA`, `GA`, `BA`.)
const COLOURS: [[&str; 2]; 3] = [["AR", "RA"], ["AG", "GA"], ["AB", "BA"]];

/// Places of the channels that are read, in the file's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ChannelChoice {
    pub(super) z: usize,
    pub(super) z_back: Option<usize>,
    pub(super) opacity: Opacity,
}

/// Where opacity is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Opacity {
    None,
    Mono(usize),
    Colour([usize; 3]),
}

/// Why no channels were chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// What is looked for isn't there: another part may have it.
    Missing(String),
    /// There are several of it, or a part of it.
    Unclear(String),
}

impl Refusal {
    pub(super) fn reason(self) -> String {
        match self {
            Self::Missing(reason) | Self::Unclear(reason) => reason,
        }
    }
}

impl ChannelChoice {
    /// Chooses among the channels of a part.
    pub(super) fn find<N: AsRef<str>>(
        names: &[N],
        selection: &Selection,
        is_flat: bool,
    ) -> Result<Self, Refusal> {
        let names = Names { names: &names.iter().map(AsRef::as_ref).collect::<Vec<_>>() };
        let z = names.depth(selection, is_flat)?;
        let layer = layer_of(names.names[z]);
        let z_back = match selection.channels.z_back.as_deref() {
            Some("") => None,
            Some(name) => Some(names.named(name)?),
            None => names.inside(layer, "ZBack"),
        };
        Ok(Self { z, z_back, opacity: names.opacity(layer, selection)? })
    }

    /// The names of what is read.
    pub(super) fn names<N: AsRef<str>>(&self, names: &[N]) -> ReadChannels {
        let name = |index: usize| names[index].as_ref().to_owned();
        ReadChannels {
            z: name(self.z),
            z_back: self.z_back.map(name),
            opacity: match self.opacity {
                Opacity::None => Vec::new(),
                Opacity::Mono(index) => vec![name(index)],
                Opacity::Colour(colours) => colours.map(name).to_vec(),
            },
        }
    }
}

/// What stands before a name's last component, with the dot.
fn layer_of(name: &str) -> &str {
    &name[..name.rfind('.').map_or(0, |dot| dot + 1)]
}

fn last_of(name: &str) -> &str {
    &name[layer_of(name).len()..]
}

struct Names<'a> {
    names: &'a [&'a str],
}

/// Opacities of one layer.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct Alphas {
    mono: Option<usize>,
    colours: [Option<usize>; 3],
}

impl Alphas {
    fn is_empty(self) -> bool {
        self == Self::default()
    }
}

impl Names<'_> {
    fn named(&self, name: &str) -> Result<usize, Refusal> {
        let missing = || Refusal::Missing(format!("no channel is called '{name}'"));
        self.names.iter().position(|&own| own == name).ok_or_else(missing)
    }

    fn inside(&self, layer: &str, last: &str) -> Option<usize> {
        self.names.iter().position(|name| name.strip_prefix(layer) == Some(last))
    }

    fn depth(&self, selection: &Selection, is_flat: bool) -> Result<usize, Refusal> {
        if let Some(name) = &selection.channels.z {
            return self.named(name);
        }
        let layer =
            selection.layer.as_ref().map(|layer| format!("{}.", layer.trim_end_matches('.')));
        let layer = layer.as_deref().unwrap_or("");
        let lasts: &[&str] = if is_flat { &["Z", "V"] } else { &["Z"] };
        for last in lasts {
            if let Some(own) = self.inside(layer, last) {
                return Ok(own);
            }
            let is_candidate = |name: &str| {
                let own = layer_of(name);
                own.starts_with(layer) && last_of(name) == *last && !self.is_vector(own, last)
            };
            let found: Vec<_> =
                (0..self.names.len()).filter(|&i| is_candidate(self.names[i])).collect();
            match found.as_slice() {
                [] => {}
                [only] => return Ok(*only),
                several => {
                    let listed = self.list(several);
                    return Err(Refusal::Unclear(format!(
                        "its depth may be any of {listed}: choose by --layer or --channels Z=NAME"
                    )));
                }
            }
        }
        Err(Refusal::Missing(match &selection.layer {
            Some(layer) => format!("the layer '{layer}' has no depth"),
            None => "no channel is its depth: --channels Z=NAME chooses one".to_owned(),
        }))
    }

    /// Whether `last` is a coordinate of something, such as a normal, in this layer.
    fn is_vector(&self, layer: &str, last: &str) -> bool {
        let others: &[&str] = if last == "Z" { &["X", "Y"] } else { &["U"] };
        others.iter().all(|other| self.inside(layer, other).is_some())
    }

    fn opacity(&self, depth_layer: &str, selection: &Selection) -> Result<Opacity, Refusal> {
        let asked = &selection.channels;
        if asked.alpha.is_some() || asked.colours.iter().any(Option::is_some) {
            let place = |name: &Option<String>| match name.as_deref() {
                None | Some("") => Ok(None),
                Some(name) => self.named(name).map(Some),
            };
            let mut alphas = Alphas { mono: place(&asked.alpha)?, ..Alphas::default() };
            for (own, name) in alphas.colours.iter_mut().zip(&asked.colours) {
                *own = place(name)?;
            }
            return self.coloured(alphas);
        }
        let own = self.alphas(depth_layer);
        if !own.is_empty() {
            return self.coloured(own);
        }
        let mut with_alpha: Vec<_> = self.names.iter().map(|name| layer_of(name)).collect();
        with_alpha.sort_unstable();
        with_alpha.dedup();
        with_alpha.retain(|layer| !self.alphas(layer).is_empty());
        // Passes of one picture stand in layers of one layer: the nearest ones count.
        let mut around = depth_layer;
        loop {
            around = layer_of(around.strip_suffix('.').unwrap_or(around));
            let nearest = with_alpha.iter().filter(|layer| layer.starts_with(around));
            match nearest.copied().collect::<Vec<_>>().as_slice() {
                [] if around.is_empty() => return Ok(Opacity::None),
                [] => {}
                [only] => return self.coloured(self.alphas(only)),
                several if several.contains(&around) => return self.coloured(self.alphas(around)),
                several => {
                    let alphas = several.iter().map(|layer| self.alphas(layer));
                    let every = alphas
                        .flat_map(|a| a.mono.into_iter().chain(a.colours.into_iter().flatten()));
                    let listed = self.list(&every.collect::<Vec<_>>());
                    return Err(Refusal::Unclear(format!(
                        "its opacity may be any of {listed}: choose by --channels A=NAME"
                    )));
                }
            }
        }
    }

    /// The opacities of a layer; ids and coverages of Cryptomatte and the third
    /// channel of UV passes are none.
    fn alphas(&self, layer: &str) -> Alphas {
        let is_id = layer.split('.').any(|name| name.to_ascii_lowercase().starts_with("crypto"));
        if is_id || self.inside(layer, "U").is_some() && self.inside(layer, "V").is_some() {
            return Alphas::default();
        }
        Alphas {
            mono: self.inside(layer, "A"),
            colours: COLOURS.map(|either| either.iter().find_map(|name| self.inside(layer, name))),
        }
    }

    /// Of colours without an opacity of their own `A` is it; a single opacity is that
    /// of all.
    fn coloured(&self, Alphas { mono, colours }: Alphas) -> Result<Opacity, Refusal> {
        let own: Vec<_> = colours.iter().flatten().copied().collect();
        match (colours.map(|own| own.or(mono)), own.as_slice()) {
            (_, []) => Ok(mono.map_or(Opacity::None, Opacity::Mono)),
            ([Some(red), Some(green), Some(blue)], _) => Ok(Opacity::Colour([red, green, blue])),
            (_, &[only]) => Ok(Opacity::Mono(only)),
            (colours, own) => {
                let colours = colours.iter().zip(["red", "green", "blue"]);
                let missing: Vec<_> =
                    colours.filter(|(own, _)| own.is_none()).map(|(_, name)| name).collect();
                Err(Refusal::Unclear(format!(
                    "there is opacity for {} only, none for {}, and no A: --channels A=NAME \
                     chooses one",
                    self.list(own),
                    missing.join(" and ")
                )))
            }
        }
    }

    fn list(&self, indices: &[usize]) -> String {
        const SHOWN: usize = 16;
        let mut names: Vec<_> = indices.iter().take(SHOWN).map(|&i| self.names[i]).collect();
        if indices.len() > SHOWN {
            names.push("…");
        }
        names.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn find(names: &[&str], selection: &Selection, is_flat: bool) -> Result<String, String> {
        let choice = ChannelChoice::find(names, selection, is_flat).map_err(Refusal::reason)?;
        let ReadChannels { z, z_back, opacity } = choice.names(names);
        Ok([vec![z], z_back.into_iter().collect(), opacity].concat().join(" "))
    }

    fn chosen(names: &str, is_flat: bool) -> Result<String, String> {
        let names: Vec<_> = names.split(' ').collect();
        find(&names, &Selection::default(), is_flat)
    }

    #[test]
    fn one_candidate_is_taken() {
        for (names, is_flat, want) in [
            ("A Z ZBack", false, "Z ZBack A"),
            ("beauty.A beauty.Z beauty.ZBack", false, "beauty.Z beauty.ZBack beauty.A"),
            (".A .Z", false, ".Z .A"),
            ("RGBA.A RGBA.B RGBA.G RGBA.R Z", false, "Z RGBA.A"),
            ("A Z spec.A spec.Z", false, "Z A"),
            ("A depth.Z spec.A", false, "depth.Z A"),
            ("V", true, "V"),
            ("L.Combined.A L.Depth.V M.Combined.A", true, "L.Depth.V L.Combined.A"),
            ("Combined.A Depth.Z N.X N.Y N.Z UV.A UV.U UV.V", true, "Depth.Z Combined.A"),
            ("CryptoAsset00.A CryptoAsset00.R Z rgba.A", false, "Z rgba.A"),
            ("CryptoAsset00.A Z", false, "Z"),
            ("AR Z", false, "Z AR"),
            ("AB AG AR Z", false, "Z AR AG AB"),
            ("BA GA RA Z", false, "Z RA GA BA"),
            ("A AR Z", false, "Z AR A A"),
            ("a.AR a.Z", false, "a.Z a.AR"),
        ] {
            assert_eq!(chosen(names, is_flat).as_deref(), Ok(want), "{names}");
        }
    }

    #[test]
    fn several_candidates_are_listed_with_the_switch() {
        for (names, listed, switch) in [
            ("a.A a.Z b.A b.Z", "a.Z, b.Z", "--layer"),
            ("Z a.A b.A", "a.A, b.A", "--channels A="),
            ("V", "no channel is its depth", "--channels Z="),
            ("N.X N.Y N.Z", "no channel is its depth", "--channels Z="),
            ("AG AR Z", "AR, AG only, none for blue", "--channels A="),
        ] {
            let error = chosen(names, false).unwrap_err();
            assert!(error.contains(listed) && error.contains(switch), "{names}: {error}");
        }
    }

    #[test]
    fn a_layer_is_taken_with_its_alpha_and_channels_win_over_it() {
        let names = ["a.A", "a.Z", "a.ZBack", "b.A", "b.deep.Z", "c.Z", "odd"];
        let of = |layer: &str, channels: &str| {
            let mut selection = Selection::default();
            if !layer.is_empty() {
                selection = selection.layer(layer);
            }
            if !channels.is_empty() {
                selection = selection.channels(channels.parse().unwrap());
            }
            find(&names, &selection, false)
        };
        assert_eq!(of("a", "").as_deref(), Ok("a.Z a.ZBack a.A"));
        assert_eq!(of("b", "").as_deref(), Ok("b.deep.Z b.A"));
        assert!(of("c", "").unwrap_err().contains("a.A, b.A"));
        assert!(of("d", "").unwrap_err().contains("'d' has no depth"));
        assert_eq!(of("c", "A=odd").as_deref(), Ok("c.Z odd"));
        assert_eq!(of("c", "A=").as_deref(), Ok("c.Z"));
        assert_eq!(of("a", "Z=odd,A=b.A").as_deref(), Ok("odd b.A"));
        assert_eq!(of("a", "ZBack=").as_deref(), Ok("a.Z a.A"));
        assert_eq!(of("a", "AR=odd,AG=b.A,AB=a.A").as_deref(), Ok("a.Z a.ZBack odd b.A a.A"));
        assert!(of("", "Z=none").unwrap_err().contains("'none'"));
    }
}
