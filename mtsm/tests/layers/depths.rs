//! Multilayer depth maps.

use dsm_core::{Error, RayHits, RaySource, SamplePoint, SurfaceHit};
use mtsm::{MultilayerBaker, MultilayerSettings};

/// Sheets of which pixel (x, y) meets x + 2 y, the farthest first.
fn source() -> RaySource<impl Fn(SamplePoint, &mut RayHits<f32>) -> Result<(), Error> + Sync> {
    RaySource(|point: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
        assert_eq!((point.x.fract(), point.y.fract(), point.time), (0.5, 0.5, 0.5));
        let count = point.x.floor() + 2.0 * point.y.floor();
        for sheet in (0..count as u8).rev() {
            let depth = 1.0 + f32::from(sheet);
            ray.push_surface(SurfaceHit { depth, opacity: 1.0 / depth })?;
        }
        ray.push_slab(0.5, 9.0, 0.5)
    })
}

#[test]
fn pixels_keep_their_first_hits_whatever_the_tiles() {
    for tile_size in [1, 3, 64] {
        let mut settings = MultilayerSettings::new([5, 4]).unwrap();
        settings.bake.tile_size = tile_size;
        settings.max_layers = 4;
        let baker = MultilayerBaker::new(source(), settings).unwrap();
        let map = baker.depth_map().unwrap();
        for (pixel, count) in (0..20_u8).map(|pixel| (pixel, pixel % 5 + 2 * (pixel / 5))) {
            let layers: Vec<_> = map.pixels().layers(pixel.into()).collect();
            let expected = (1..=count.min(4)).map(f32::from);
            let expected = expected.map(|depth| SurfaceHit { depth, opacity: 1.0 / depth });
            assert!(layers.into_iter().eq(expected), "{pixel}");
        }
        if tile_size == 64 {
            assert_eq!(baker.depth_tile([0, 0]).unwrap().cut_pixels, 11);
        }
    }
}

#[test]
fn hits_before_the_light_are_dropped() {
    let settings =
        MultilayerSettings { light_depth: 2.0, ..MultilayerSettings::new([5, 4]).unwrap() };
    let map = MultilayerBaker::new(source(), settings).unwrap().depth_map().unwrap();
    assert_eq!(map.pixels().depth_range(4), Some([3.0, 4.0]));
}
