//! The switches of `report`.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::RangedU64ValueParser;

use super::values::{self, Effort};

const EXAMPLES: &str = "\
Examples:
  dsm-tools report builtin:hairball --html hair.html
  dsm-tools report scene.toml hair.dsm soft.dsm --html look.html --times
  dsm-tools report hair.dsm smoke.dsm --html maps.html";

/// Writes a page that shows how a scene's shadows come out by every method
///
/// Renders the scene by each method, through the MAPs that are given or through maps that are
/// baked for it, and shows what each map is, the pictures, how far they are from rays through the
/// scene, and a table and a plot of that. Of MAPs alone it shows what they are and the light
/// that they leave. The same arguments write the same bytes.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ReportFlags {
    /// A scene (as bake takes it) and maps of its light, or maps alone (.dsm)
    #[arg(required = true, value_name = "SCENE|MAP")]
    inputs: Vec<PathBuf>,
    /// The page to write
    #[arg(long, value_name = "OUT", value_parser = values::html_file())]
    html: PathBuf,
    /// Width and height of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "240x180", value_parser = values::resolution)]
    resolution: [u32; 2],
    /// Camera rays a pixel
    #[arg(long, value_name = "N", default_value = "4")]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=4096))]
    samples: u32,
    /// Shadow rays from every point, of methods that trace; a square number; the reference
    /// takes four times as many
    #[arg(long, value_name = "N", default_value = "64", value_parser = square)]
    rays: u32,
    /// Show shaded pictures, not the shadow factor alone
    #[arg(long)]
    shaded: bool,
    /// Add seconds and memory to the table: two runs then write different bytes
    #[arg(long)]
    times: bool,
    /// Seed of maps and rays
    #[arg(long, value_name = "N", default_value = "0")]
    seed: u64,
    #[command(flatten)]
    effort: Effort,
    /// Show no progress, and print nothing
    #[arg(long)]
    quiet: bool,
}

/// A checked `report`.
#[derive(Debug)]
pub(crate) struct Report {
    pub(crate) scene: Option<PathBuf>,
    pub(crate) maps: Vec<PathBuf>,
    pub(crate) html: PathBuf,
    pub(crate) resolution: [u32; 2],
    pub(crate) samples: u32,
    pub(crate) rays: u32,
    pub(crate) shaded: bool,
    pub(crate) times: bool,
    pub(crate) seed: u64,
    pub(crate) effort: Effort,
    pub(crate) quiet: bool,
}

impl TryFrom<ReportFlags> for Report {
    type Error = String;

    fn try_from(flags: ReportFlags) -> Result<Self, String> {
        let ReportFlags { inputs, html, resolution, samples, rays, shaded, times, .. } = flags;
        let (maps, scenes): (Vec<_>, Vec<_>) = inputs.into_iter().partition(|path| is_map(path));
        if scenes.len() > 1 {
            return Err("a report is about one scene; further files are maps (.dsm)".to_owned());
        }
        Ok(Self {
            scene: scenes.into_iter().next(),
            maps,
            html,
            resolution,
            samples,
            rays,
            shaded,
            times,
            seed: flags.seed,
            effort: flags.effort,
            quiet: flags.quiet,
        })
    }
}

fn is_map(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("dsm"))
}

/// A square number that all methods take.
fn square(text: &str) -> Result<u32, String> {
    let rays: u32 = text.parse().map_err(|_| "no number".to_owned())?;
    let side = rays.isqrt();
    if side * side != rays || !(1..=4096).contains(&rays) {
        return Err("a square number from 1 to 4096, such as 64".to_owned());
    }
    Ok(rays)
}
