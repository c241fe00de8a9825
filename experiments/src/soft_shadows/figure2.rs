//! Figure 2: pictures, by light and by method.

use anyhow::{Context, Result};
use dsm_scene::detail::Image;

use super::{Method, Page, Study};

/// The methods of the columns; traced shadows stand last.
const COLUMNS: [Method; 4] = [Method::Filter, Method::Single, Method::Paper, Method::Fragments];

/// Draws it of the first scene: the smallest, the middle and the largest light
/// from top to bottom.
///
/// # Errors
///
/// What the code under test says.
pub fn figure_2(study: &mut Study) -> Result<(Image, Page)> {
    let all = study.effort.radii.clone();
    let (first, last) = (all.first().context("no light")?, all.last().context("no light")?);
    let mut radii = vec![*first, all[all.len() / 2], *last];
    radii.dedup();
    let mut pixels = Vec::new();
    let mut size = [0, 0];
    for &radius in &radii {
        let lit = study.lit(0, radius)?.clone();
        let stage = &study.stages[0];
        let drawn = COLUMNS.map(|method| stage.picture(&lit.by(method)?.factors));
        let traced = stage.picture(&lit.reference);
        let drawn = drawn.into_iter().chain([traced]).collect::<Result<Vec<_>>>()?;
        let row = Image::beside(&drawn).context("all are as high")?;
        size = [row.size()[0], size[1] + row.size()[1]];
        pixels.extend_from_slice(row.pixels());
    }
    let image = Image::new(size, pixels).context("all rows are as wide")?;
    let names = COLUMNS.map(Method::name).join("; ");
    let radii: Vec<String> = radii.iter().map(f64::to_string).collect();
    let text = format!(
        include_str!("figure2.md"),
        scene = study.stages[0].name,
        names = names,
        radii = radii.join(", "),
        parameters = study.parameters(),
    );
    let pictures = vec![("images/soft-shadows.png".to_owned(), image.to_png()?)];
    Ok((image, Page { name: "soft-shadows-figure-2", text, pictures }))
}
