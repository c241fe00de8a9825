//! What holds of any lists.

use dsm_core::{Rgb, Transmittance};
use dsm_testkit::config;
use proptest::prelude::*;

use super::accumulate::Accumulate;
use super::epsilon::{Epsilon, Reach};
use super::level_plan::LevelGeometry;
use super::lists::{FragmentList, FragmentLists};
use super::lookup::{LightCone, ReceiverPlane};
use super::map::PrefilteredMap;
use super::merge::{Merge, MergedDepth};
use super::oracle;
use super::pyramid::filtered;
use super::settings::PrefilterSettings;
use super::source::PrefilteredSource;
use crate::fragments::oracle::frame;

const SIZE: [u32; 2] = [13, 9];

fn accumulate() -> impl Strategy<Value = Accumulate> {
    prop::sample::select(Accumulate::ALL.to_vec())
}

fn depth() -> impl Strategy<Value = MergedDepth> {
    prop_oneof![Just(MergedDepth::Mean), Just(MergedDepth::Weighted)]
}

/// A w, and three numbers of which opacities are made.
type Raw = (f32, [f32; 3]);

fn raw() -> impl Strategy<Value = Vec<Raw>> {
    let opacity = prop_oneof![3 => 0.01_f32..1.0, 1 => Just(1.0_f32)];
    let fragment = (0.1_f32..0.5, prop::array::uniform3(opacity));
    prop::collection::vec(fragment, 0..7)
}

fn push<T: Transmittance>(lists: &mut FragmentLists<T>, raw: &[Raw]) {
    let mut raw = raw.to_vec();
    raw.sort_by(|a, b| b.0.total_cmp(&a.0));
    raw.dedup_by_key(|fragment| fragment.0);
    for (w, channels) in raw {
        lists.push(w, T::from_channels(|channel| channels[channel]));
    }
    lists.finish_texel().unwrap();
}

/// Some texels, again and again, turned by a few at a time.
fn lists<T: Transmittance>(size: [u32; 2], texels: &[Vec<Raw>]) -> FragmentLists<T> {
    let mut lists = FragmentLists::new(size);
    for texel in 0..(size[0] * size[1]) as usize {
        push(&mut lists, &texels[(texel * 7 + texel / 11) % texels.len()]);
    }
    lists.check().unwrap();
    lists
}

fn texels() -> impl Strategy<Value = Vec<Vec<Raw>>> {
    prop::collection::vec(raw(), 5..20)
}

fn settings() -> impl Strategy<Value = PrefilterSettings> {
    let epsilon = prop_oneof![
        (0.0_f32..20.0).prop_map(Epsilon::Widths),
        (0.0_f32..3.0).prop_map(Epsilon::Interval)
    ];
    let sizes = prop_oneof![Just(None), (1_u32..9).prop_map(Some)];
    (epsilon, accumulate(), depth(), sizes, 0_u32..2, any::<bool>()).prop_map(
        |(epsilon, accumulate, depth, stack_size, subsampled, joined)| PrefilterSettings {
            epsilon,
            accumulate,
            depth,
            stack_size,
            subsampled,
            joined,
            max_level: None,
        },
    )
}

fn cone() -> impl Strategy<Value = LightCone> {
    let numbers = (-1.0_f64..14.0, -1.0_f64..10.0, 0.05_f64..0.4, 0.0_f64..0.05, 5.0_f64..200.0);
    let slopes =
        (-40.0_f64..40.0, -40.0_f64..40.0, prop::option::of((any::<bool>(), -0.01_f64..0.01)));
    (numbers, slopes).prop_map(|((x, y, w, bias, rate), (along_x, along_y, plane))| LightCone {
        place: [x, y],
        w,
        start: w + bias,
        least: if x > 7.0 { w + 1.0 / rate } else { 0.0 },
        slope: [along_x, along_y].map(|slope| slope * rate / 100.0),
        rate,
        plane: plane.map(|(is_lit, slope)| ReceiverPlane {
            slope: [slope, -slope / 2.0],
            offset: if is_lit { bias } else { -bias },
            is_lit,
        }),
    })
}

fn check_merge<T: Transmittance>(texels: &[Vec<Raw>], reach: Reach, merge: Merge) {
    let four = lists::<T>([4, 1], texels);
    let of = [0, 1, 2, 3].map(|texel| four.list(texel));
    let mut found = FragmentLists::new([1, 1]);
    merge.append(of, &mut found);
    found.finish_texel().unwrap();
    found.check().unwrap();
    let reaches = |nearest: f64, w: f64| w >= reach.end(nearest as f32);
    let expected = oracle::merged(of, reaches, merge.accumulate, merge.depth);
    let FragmentList { w, opacities } = found.list(0);
    assert_eq!(w.len(), expected.len());
    for ((w, opacity), (want, wanted)) in w.iter().zip(opacities).zip(expected) {
        assert!((f64::from(*w) - want).abs() < 1e-7, "{w} {want}");
        for (have, want) in opacity.to_sum().as_ref().iter().zip(wanted.as_ref()) {
            assert!((have - want).abs() < 1e-6, "{have} {want}");
        }
    }
}

fn check_lookup<T: Transmittance>(
    texels: &[Vec<Raw>],
    settings: &PrefilterSettings,
    cone: &LightCone,
    accumulate: Accumulate,
) {
    let map =
        PrefilteredMap::new(frame(SIZE, 0.0), lists::<T>(SIZE, texels), settings, 0.7).unwrap();
    let levels: Vec<(FragmentLists<T>, LevelGeometry)> =
        map.levels().map(|(lists, level)| (lists.clone(), *level)).collect();
    let expected = oracle::visibility(&levels, cone, accumulate);
    let Ok(found) = map.known().visibility::<T, _>(&map, cone, accumulate);
    for (have, want) in found.to_sum().as_ref().iter().zip(expected.as_ref()) {
        // What is next to nothing may be left out.
        let is_dark = accumulate == Accumulate::Multiply && *have < 1e-3 && *want < 1e-3;
        assert!(is_dark || (have - want).abs() < 1e-4, "{have} {want}");
    }
}

proptest! {
    #![proptest_config(config(0x5e16_7ad0))]

    #[test]
    fn merging_is_figure_3(
        texels in texels(), accumulate in accumulate(), depth in depth(),
        widths in 0.0_f32..0.5, share in 0.0_f32..0.2, coloured in any::<bool>(),
    ) {
        for epsilon in [Epsilon::Widths(widths), Epsilon::Interval(share)] {
            let reach = epsilon.reach(1.0, 1.0, 1.0).unwrap();
            let merge = Merge { accumulate, depth, reach };
            if coloured {
                check_merge::<Rgb>(&texels, reach, merge);
            } else {
                check_merge::<f32>(&texels, reach, merge);
            }
        }
    }

    #[test]
    fn a_list_merged_with_itself_is_itself(
        texels in texels(), accumulate in accumulate(), depth in depth(),
    ) {
        let lists = lists::<Rgb>([1, 1], &texels);
        let merge = Merge { accumulate, depth, reach: Reach::NONE };
        let mut merged = FragmentLists::new([1, 1]);
        merge.append([lists.list(0); 4], &mut merged);
        merged.finish_texel().unwrap();
        prop_assert_eq!(merged, lists);
    }

    #[test]
    fn additive_opacity_is_the_mean_of_the_four(
        texels in texels(), depth in depth(), share in 0.0_f32..0.5,
    ) {
        let sum = |list: FragmentList<'_, f32>| -> f64 {
            list.opacities.iter().map(|&opacity| f64::from(opacity)).sum()
        };
        // So little that no sum comes to 1.
        let small: Vec<Vec<Raw>> = texels
            .iter()
            .map(|texel| texel.iter().map(|(w, a)| (*w, a.map(|a| a / 8.0))).collect())
            .collect();
        let four = lists::<f32>([4, 1], &small);
        let reach = Epsilon::Interval(share).reach(1.0, 1.0, 1.0).unwrap();
        let merge = Merge { accumulate: Accumulate::Add, depth, reach };
        let mut merged = FragmentLists::new([1, 1]);
        merge.append([0, 1, 2, 3].map(|texel| four.list(texel)), &mut merged);
        merged.finish_texel().unwrap();
        let mean = (0..4).map(|texel| sum(four.list(texel))).sum::<f64>() / 4.0;
        prop_assert!((sum(merged.list(0)) - mean).abs() < 1e-6);
    }

    #[test]
    fn levels_without_epsilon_are_box_filters(
        texels in texels(), stack in prop::option::of(1_u32..9), w in 0.1_f32..0.5,
    ) {
        let base = lists::<f32>(SIZE, &texels);
        let settings = PrefilterSettings {
            epsilon: Epsilon::Interval(0.0), stack_size: stack, ..PrefilterSettings::paper()
        };
        let (levels, geometry) = filtered(base.clone(), &settings, 0.1, 1.0).unwrap();
        for (level, geometry) in levels.iter().zip(&geometry) {
            let half = f64::from(geometry.width) / 2.0;
            for texel in 0..level.texels() {
                let width = level.size()[0] as usize;
                let at = [texel % width, texel / width].map(|index| index as f64);
                let [x, y] = geometry.centre(at);
                // Nothing lies outside the map.
                let mut naive = 0.0;
                for (row, column) in
                    (0..SIZE[1]).flat_map(|row| (0..SIZE[0]).map(move |column| (row, column)))
                {
                    let off = [f64::from(column) + 0.5 - x, f64::from(row) + 0.5 - y];
                    if off.iter().all(|off| off.abs() < half) {
                        let list = base.at(column.into(), row.into());
                        let fragments = list.w.iter().zip(list.opacities);
                        naive += fragments
                            .filter(|&(&own, _)| own > w)
                            .map(|(_, &opacity)| f64::from(opacity))
                            .sum::<f64>();
                    }
                }
                let list = level.list(texel);
                let found: f64 = (list.w.iter().zip(list.opacities))
                    .filter(|&(&own, _)| own > w)
                    .map(|(_, &opacity)| f64::from(opacity))
                    .sum();
                let naive = naive / f64::from(geometry.width).powi(2);
                prop_assert!((found - naive).abs() < 1e-5, "{geometry:?} {at:?}: {found} {naive}");
            }
        }
    }

    #[test]
    fn lookups_are_naive_ones(
        texels in texels(), settings in settings(), cone in cone(), accumulate in accumulate(),
        coloured in any::<bool>(),
    ) {
        if coloured {
            check_lookup::<Rgb>(&texels, &settings, &cone, accumulate);
        } else {
            check_lookup::<f32>(&texels, &settings, &cone, accumulate);
        }
    }

    #[test]
    fn a_light_of_no_size_reads_one_list(texels in texels(), cone in cone()) {
        let base = lists::<f32>(SIZE, &texels);
        let settings = PrefilterSettings::default();
        let map = PrefilteredMap::new(frame(SIZE, 0.0), base.clone(), &settings, 0.7).unwrap();
        let cone = LightCone { rate: 0.0, plane: None, ..cone };
        let Ok(found) = map.known().visibility::<f32, _>(&map, &cone, Accumulate::Multiply);
        let [x, y] = cone.place.map(|at| at.floor() as i64);
        let list = base.at(x, y);
        let nearer = list.w.iter().zip(list.opacities);
        let nearer = nearer.filter(|&(&w, _)| f64::from(w) > cone.start.max(cone.least));
        let left: f64 = nearer.map(|(_, &opacity)| 1.0 - f64::from(opacity)).product();
        prop_assert!((f64::from(found) - left).abs() < 1e-6, "{found} {left}");
    }
}
