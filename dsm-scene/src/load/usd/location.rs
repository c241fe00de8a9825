//! Places of layers: files, and members of archives.

use std::path::{Path, PathBuf};

/// Where a layer is.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Location {
    pub(super) file: PathBuf,
    /// The member of an archive; its first one if empty.
    pub(super) member: Option<String>,
}

impl Location {
    pub(super) fn of_file(path: &Path) -> Self {
        let is_archive = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("usdz"));
        Self { file: path.to_owned(), member: is_archive.then(String::new) }
    }

    /// What `asset` means in the layer here.
    pub(super) fn resolve(&self, asset: &str) -> Self {
        if let Some((archive, member)) =
            asset.split_once('[').and_then(|(file, rest)| Some((file, rest.strip_suffix(']')?)))
        {
            let file = self.resolve(archive).file;
            return Self { file, member: Some(member.to_owned()) };
        }
        match &self.member {
            Some(member) => {
                let folder = member.rsplit_once('/').map_or("", |(folder, _)| folder);
                let joined = format!("{folder}/{asset}");
                let mut parts: Vec<&str> = Vec::new();
                for part in joined.split('/') {
                    match part {
                        "" | "." => {}
                        ".." => drop(parts.pop()),
                        part => parts.push(part),
                    }
                }
                Self { file: self.file.clone(), member: Some(parts.join("/")) }
            }
            None => {
                let asset = asset.strip_prefix("./").unwrap_or(asset);
                let folder = self.file.parent().unwrap_or(Path::new(""));
                Self::of_file(&folder.join(asset))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assets_are_found_beside_what_names_them() {
        let file = Location::of_file(Path::new("a/b.usda"));
        assert_eq!(file.resolve("./c.usd").file, Path::new("a/c.usd"));
        assert_eq!(file.resolve("c.usdz").member.as_deref(), Some(""));
        let packed = file.resolve("c.usdz[d/e.usda]");
        assert_eq!(packed.file, Path::new("a/c.usdz"));
        assert_eq!(packed.resolve("../f/g.usda").member.as_deref(), Some("f/g.usda"));
        assert_eq!(packed.resolve("./g.usda").member.as_deref(), Some("d/g.usda"));
    }
}
