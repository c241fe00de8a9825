//! Point instancers: copies of prototypes.

use std::collections::HashSet;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::attributes::{Spread, broken, indices};
use super::{Inherited, Item, Reader};
use crate::error::Result;
use crate::load::usd::stage::Prim;
use crate::load::usd::value::Numbers;

impl Reader<'_, '_> {
    /// Adds the copies that a point instancer makes. A copy is scaled, turned and moved,
    /// after its prototype's own transform.
    pub(super) fn instancer(&mut self, prim: &Prim, inherited: &Inherited) -> Result<()> {
        let Some(which) = self.numbers(prim, "protoIndices")? else { return Ok(()) };
        let which = indices(prim, "protoIndices", &which)?;
        let positions = self.vectors(prim, "positions")?.unwrap_or_default();
        if positions.len() != which.len() {
            let reason = format!("{} positions for {} copies", positions.len(), which.len());
            return Err(broken(prim, reason));
        }
        let scales = self.vectors(prim, "scales")?.filter(|scales| !scales.is_empty());
        let mut turns = self.turns(prim, "orientationsf")?;
        if turns.is_empty() {
            turns = self.turns(prim, "orientations")?;
        }
        let fits = |count: usize| count == 0 || count == which.len();
        if !fits(turns.len()) || !fits(scales.as_ref().map_or(0, Vec::len)) {
            return Err(broken(prim, "scales or orientations do not fit its copies"));
        }
        let hidden = self.hidden(prim, which.len())?;
        let opacity = self.opacity(prim)?.filter(|opacity| opacity.spread != Spread::Constant);
        let opacity = opacity.filter(|opacity| opacity.data.len() == which.len());

        let paths = prim.targets(self.stage, "prototypes")?;
        let mut prototypes = Vec::new();
        for path in &paths {
            prototypes.push(self.prototype(prim, path, inherited)?);
        }
        for (copy, &prototype) in which.iter().enumerate() {
            if hidden[copy] {
                continue;
            }
            let Some(items) = prototypes.get(prototype as usize) else {
                let reason = format!("there is no prototype {prototype}");
                return Err(broken(prim, reason));
            };
            let scale = scales.as_ref().map_or(DVec3::ONE, |scales| scales[copy].into());
            let turn = turns.get(copy).copied().unwrap_or(DMat3::IDENTITY);
            let placed = DAffine3::from_mat3_translation(
                turn * DMat3::from_diagonal(scale),
                positions[copy].into(),
            );
            let to_world = inherited.to_world * placed;
            for item in items {
                let own = opacity.as_ref().map(|opacity| opacity.data[copy] as f32);
                self.push(Item {
                    to_world: to_world * item.to_world,
                    inherited: item.inherited.or(own),
                    ..item.clone()
                })?;
            }
        }
        Ok(())
    }

    /// What a prototype draws, in the space of a copy.
    fn prototype(&mut self, prim: &Prim, path: &str, inherited: &Inherited) -> Result<Vec<Item>> {
        let Some(prototype) = self.stage.prim(path)? else {
            let line = format!("{}: there is no prototype {path}", prim.path);
            self.stage.warnings.add(line);
            return Ok(Vec::new());
        };
        let inherited =
            Inherited { to_world: DAffine3::IDENTITY, opacity: None, ..inherited.clone() };
        let outer = std::mem::take(&mut self.items);
        let found = self.visit(&prototype, &inherited, true);
        let items = std::mem::replace(&mut self.items, outer);
        found.map(|()| items)
    }

    fn turns(&self, prim: &Prim, name: &str) -> Result<Vec<DMat3>> {
        let Some(Numbers { size: 4, data, .. }) = self.numbers(prim, name)? else {
            return Ok(Vec::new());
        };
        // As they are, like the standard's own library: no unit quaternions scale.
        let turn = |quat: &[f64; 4]| DMat3::from_quat(DQuat::from_array(*quat));
        Ok(data.as_chunks::<4>().0.iter().map(turn).collect())
    }

    /// Which copies are switched off, by their ids.
    fn hidden(&self, prim: &Prim, count: usize) -> Result<Vec<bool>> {
        let mut off: HashSet<i64> = HashSet::new();
        if let Some(ids) = self.numbers(prim, "invisibleIds")? {
            off.extend(ids.data.iter().map(|&id| id as i64));
        }
        off.extend(prim.integers(self.stage, "inactiveIds")?);
        let ids = self.numbers(prim, "ids")?.filter(|ids| ids.data.len() == count);
        let id = |copy: usize| ids.as_ref().map_or(copy as i64, |ids| ids.data[copy] as i64);
        Ok((0..count).map(|copy| off.contains(&id(copy))).collect())
    }
}
