//! Pictures that begin with their G-buffer.

use bevy::prelude::*;
use sunroom::engine::{RenderControl, RenderFilm};
use sunroom::render::tile::tiles;

use crate::{ball, finish};

#[test]
fn the_gbuffer_is_there_if_it_is_asked_for_and_changes_no_sample() {
    let picture = |gbuffer| {
        let mut app = ball(Vec3::new(0.0, 0.0, 4.0), 70, 40);
        app.world_mut().resource_mut::<RenderControl>().gbuffer = gbuffer;
        finish(&mut app);
        app.world_mut().remove_resource::<RenderFilm>().expect("a film")
    };
    let (with, without) = (picture(true), picture(false));
    assert_eq!(with.film, without.film);
    assert!(without.gbuffer.is_empty());
    assert_eq!(with.gbuffer.len(), tiles(70, 40).len());
    let mut surfaces = 0;
    for part in &with.gbuffer {
        let tile = part.tile;
        let rows = tile.y..tile.y + tile.height;
        let pixels = rows.flat_map(|y| (tile.x..tile.x + tile.width).map(move |x| (x, y)));
        for ((x, y), texel) in pixels.zip(&part.texels) {
            surfaces += u32::from(texel.is_surface());
            let depth = without.film.pixel(x, y).expect("it is rendered").depth;
            if depth == 0.0 {
                assert!(!texel.is_surface(), "{x} {y}");
            }
            if (x, y) == (35, 20) {
                assert!((texel.distance - 3.0).abs() < 0.01 && !texel.is_specular, "{texel:?}");
            }
        }
    }
    assert!((100..2000).contains(&surfaces), "{surfaces}");
}
