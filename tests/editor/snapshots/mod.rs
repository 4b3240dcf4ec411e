//! Pictures of panels in both themes, which hold their look. A picture that differs from the one in this folder is
//! written into the build folder beside the difference; `UPDATE_SNAPSHOTS=1 cargo test --test editor snapshots` takes
//! it over. Look at it before it is committed.

mod covers;
mod objects;
mod panels;
mod rasteriser;
mod scene;

use std::path::PathBuf;

use bevy_egui::egui::{self, Color32, Frame, LayerId, Margin, Pos2, Rect, Theme, Ui, UiBuilder};
use egui_kittest::Harness;
use image::{Rgb, RgbImage, imageops};
use sunroom::app::editor::command::panel::Panel;
use sunroom::app::editor::window::style::set_styles;

use rasteriser::{Textures, draw};

/// Stored colours are multiples of this, which makes the files a third smaller.
const STEP: u8 = 8;
/// The pixels at which a channel differs by more than so much, of 255, are counted in tiles: those of a letter.
const CLEAR: u8 = 3 * STEP;
/// The edge of a tile in pixels, and the number of clear differences that a tile may have: fewer than those of a full
/// stop.
const TILE: u32 = 32;
const MOST_IN_TILE: u32 = 1;
/// The pixels at which a channel differs by more than so much are counted in the whole picture: those of a fill.
const FAINT: u8 = STEP;
/// The largest share of faint differences.
const MOST_FAINT: f64 = 5e-3;
/// The grey around what is shown, as that of a picture.
const BEHIND: Color32 = Color32::from_gray(96);

/// One test for each picture, which is the result of the function of that name.
macro_rules! snapshots {
    ($($module:ident { $($name:ident),* $(,)? })*) => {
        const NAMES: &[&str] = &[$($(stringify!($name)),*),*];

        $($(
            #[test]
            fn $name() {
                compare(stringify!($name), &$module::$name());
            }
        )*)*
    };
}

snapshots! {
    objects {
        cube, sphere_that_shines, wall, stairs, mesh_that_is_missing, group, several,
        principled, rough_conductor, dielectric, textured, two_sided,
        point, spot, sky, projector, sun_and_sky, fog, camera, nothing_selected,
    }
    panels {
        outliner, render, render_of_layers, render_in_a_narrow_panel, mixing_and_comparison, light_painting, library, assets, history, messages, meter, statistics, paths, reasons, lamp_light, timeline, status_line,
        status_line_while_denoised, bake_form, bake_progress, color_picker,
    }
    covers {
        start_page, start_page_of_a_first_start, preferences, key_list, key_overview, palette, file_dialog, save_dialog,
        file_menu, edit_menu, add_menu, arrange_menu, view_menu, time_menu, render_menu, window_menu, toolbar, icons,
        series_of_copies, missing_files, unsaved_edits, recovery, render_full_film, dropped_scene, access_to_files,
        messages_over_the_picture, tutorial,
    }
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/editor/snapshots")
}

#[test]
fn every_picture_in_the_folder_is_compared() {
    for entry in std::fs::read_dir(folder())
        .expect("the folder of the pictures")
        .flatten()
    {
        let path = entry.path();
        if path.extension().is_some_and(|extension| extension == "png") {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            assert!(NAMES.contains(&name.as_str()), "{} is not used", path.display());
        }
    }
}

/// The pictures of a panel that can be closed.
fn pictures_of(panel: Panel) -> &'static [&'static str] {
    match panel {
        Panel::Viewport => &["toolbar", "icons"],
        Panel::Outliner => &["outliner"],
        Panel::Library => &["library"],
        Panel::Assets => &["assets"],
        Panel::Inspector => &["cube", "principled", "spot", "camera"],
        Panel::Render => &["render"],
        Panel::History => &["history"],
        Panel::Messages => &["messages"],
        Panel::Paths => &["paths", "reasons", "lamp_light"],
        Panel::Meter => &["meter"],
        Panel::Statistics => &["statistics"],
        Panel::Bake => &["bake_progress"],
    }
}

#[test]
fn every_panel_has_a_picture() {
    for &panel in Panel::CLOSEABLE {
        let pictures = pictures_of(panel);
        assert!(!pictures.is_empty(), "{panel:?}");
        for name in pictures {
            assert!(NAMES.contains(name), "{panel:?}: {name}");
        }
    }
}

#[test]
fn a_letter_more_is_a_difference_and_rounding_is_none() {
    // The size of a page, whose other pixels are all alike.
    for size in [[200, 60], [1200, 1000]] {
        let text = |text: &'static str| {
            let show = move |ui: &mut Ui, (): &mut ()| {
                ui.label(text);
                ui.add_space(size[1] as f32 - 50.0);
                ui.label("foot");
            };
            in_both_themes(size, (), show, |_| ())
        };
        let one = text("a panel");
        assert!(difference(&one, &one).is_none());
        for other in ["a panels", "a pane1", "a panel."] {
            assert!(difference(&one, &text(other)).is_some(), "{other}, {size:?}");
        }
        let mut rounded = one.clone();
        for channel in rounded.pixels_mut().flat_map(|pixel| &mut pixel.0) {
            *channel = channel.saturating_add(5);
        }
        assert!(difference(&one, &rounded).is_none());
    }
}

#[test]
fn another_shade_of_a_fill_is_a_difference() {
    let filled = |gray: u8| {
        let show = move |ui: &mut Ui, (): &mut ()| {
            let place = Rect::from_min_size(Pos2::new(10.0, 10.0), egui::vec2(120.0, 60.0));
            ui.painter().rect_filled(place, 0.0, Color32::from_gray(gray));
        };
        in_both_themes([600, 400], (), show, |_| ())
    };
    assert!(difference(&filled(40), &filled(40)).is_none());
    assert!(difference(&filled(40), &filled(56)).is_some());
}

/// What is shown, dark at the left and light at the right, after `act`. The rows at the bottom without anything are
/// left out.
fn in_both_themes<T: Clone + 'static>(
    size: [u32; 2],
    given: T,
    show: impl Fn(&mut Ui, &mut T) + Clone + 'static,
    act: impl Fn(&mut Harness<T>),
) -> RgbImage {
    let [dark, light] = [Theme::Dark, Theme::Light].map(|theme| {
        let textures = Textures::default();
        let show = show.clone();
        let mut harness = Harness::builder()
            .with_size(egui::vec2(size[0] as f32, size[1] as f32))
            .with_theme(theme)
            .renderer(textures.clone())
            .build_ui_state(
                move |ui: &mut Ui, given: &mut T| {
                    set_styles(ui.ctx());
                    // The window has no margin.
                    let builder = UiBuilder::new()
                        .layer_id(LayerId::background())
                        .max_rect(ui.ctx().viewport_rect());
                    show(&mut Ui::new(ui.ctx().clone(), "window".into(), builder), given);
                },
                given.clone(),
            );
        harness.run_steps(4);
        act(&mut harness);
        // The pointer is not shown, and covers change their size in their first frames.
        harness.run_steps(4);
        let output = harness.output();
        let shapes = harness.ctx.tessellate(output.shapes.clone(), output.pixels_per_point);
        draw(size, BEHIND, &shapes, &textures)
    });
    const GAP: u32 = 4;
    let rows = used_rows(&dark).max(used_rows(&light));
    let mut both = RgbImage::from_pixel(2 * size[0] + GAP, rows, Rgb([0; 3]));
    imageops::replace(&mut both, &dark, 0, 0);
    imageops::replace(&mut both, &light, (size[0] + GAP).into(), 0);
    for channel in both.pixels_mut().flat_map(|pixel| &mut pixel.0) {
        *channel = ((u16::from(*channel) + u16::from(STEP / 2)) / u16::from(STEP) * u16::from(STEP)).min(255) as u8;
    }
    both
}

/// A panel of the window in both themes.
fn panel<T: Clone + 'static>(
    size: [u32; 2],
    given: T,
    show: impl Fn(&mut Ui, &mut T) + Clone + 'static,
    act: impl Fn(&mut Harness<T>),
) -> RgbImage {
    let in_panel = move |ui: &mut Ui, given: &mut T| {
        let frame = Frame::new()
            .fill(ui.visuals().panel_fill)
            .inner_margin(Margin::symmetric(6, 5));
        egui::CentralPanel::default()
            .frame(frame)
            .show(ui, |ui| show(ui, given));
    };
    in_both_themes(size, given, in_panel, act)
}

/// The rows down to the last one that differs from those below it.
fn used_rows(picture: &RgbImage) -> u32 {
    const MARGIN: u32 = 8;
    let width = picture.width();
    let last = picture.height() - 1;
    let is_same = |row: u32| (0..width).all(|x| picture.get_pixel(x, row) == picture.get_pixel(x, last));
    let used = (0..=last).rev().find(|row| !is_same(*row)).map_or(1, |row| row + 1);
    (used + MARGIN).min(last + 1)
}

fn compare(name: &str, now: &RgbImage) {
    let path = folder().join(name).with_extension("png");
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        let known = image::open(&path).map(|known| known.to_rgb8());
        if !known.is_ok_and(|known| difference(&known, now).is_none()) {
            std::fs::write(&path, encoded(now)).expect("the folder can be written");
        }
        return;
    }
    let failed = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("snapshots");
    let write = |name: String, picture: &RgbImage| {
        std::fs::create_dir_all(&failed).expect("the build folder can be written");
        let path = failed.join(name).with_extension("png");
        std::fs::write(&path, encoded(picture)).expect("the build folder can be written");
        path
    };
    const ADVICE: &str = "if it looks right, UPDATE_SNAPSHOTS=1 takes it over";
    let Ok(known) = image::open(&path) else {
        let now = write(name.to_owned(), now);
        panic!(
            "there is no {}; {} is the new picture: {ADVICE}",
            path.display(),
            now.display()
        );
    };
    if let Some((marked, share)) = difference(&known.to_rgb8(), now) {
        let now = write(name.to_owned(), now);
        let marked = write(format!("{name}-difference"), &marked);
        panic!(
            "{:.3} % of {name} differ: {} is the new picture, {} has the differences in white; {ADVICE}",
            100.0 * share,
            now.display(),
            marked.display()
        );
    }
}

/// The pixels that differ in white, and their share; None if there are few enough. Pictures of different sizes differ
/// where one of them has no pixel.
fn difference(known: &RgbImage, now: &RgbImage) -> Option<(RgbImage, f64)> {
    let (width, height) = (known.width().max(now.width()), known.height().max(now.height()));
    let tiles = [width, height].map(|edge| edge.div_ceil(TILE) as usize);
    let mut in_tiles = vec![0; tiles[0] * tiles[1]];
    let mut faint = 0;
    let marked = RgbImage::from_fn(width, height, |x, y| {
        let differs_by = match (known.get_pixel_checked(x, y), now.get_pixel_checked(x, y)) {
            (Some(one), Some(other)) => {
                let channels = one.0.iter().zip(other.0);
                channels.map(|(one, other)| one.abs_diff(other)).max().unwrap_or(0)
            }
            _ => u8::MAX,
        };
        in_tiles[(y / TILE) as usize * tiles[0] + (x / TILE) as usize] += u32::from(differs_by > CLEAR);
        faint += u32::from(differs_by > FAINT);
        Rgb([if differs_by > FAINT { 255 } else { 0 }; 3])
    });
    let share = f64::from(faint) / (f64::from(width) * f64::from(height));
    let is_clear = in_tiles.iter().any(|count| *count > MOST_IN_TILE);
    (is_clear || share > MOST_FAINT).then_some((marked, share))
}

/// The picture as PNG, with a palette if 256 colours suffice: half as large.
fn encoded(picture: &RgbImage) -> Vec<u8> {
    let mut colors: Vec<[u8; 3]> = picture.pixels().map(|pixel| pixel.0).collect();
    colors.sort_unstable();
    colors.dedup();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width(), picture.height());
    encoder.set_compression(png::Compression::High);
    // Lines of text compress best as they are.
    encoder.set_filter(png::Filter::NoFilter);
    let is_indexed = colors.len() <= 256;
    encoder.set_color(if is_indexed {
        png::ColorType::Indexed
    } else {
        png::ColorType::Rgb
    });
    let data = match is_indexed {
        true => {
            encoder.set_palette(colors.as_flattened().to_vec());
            let index = |pixel: &Rgb<u8>| colors.binary_search(&pixel.0).unwrap_or_default() as u8;
            picture.pixels().map(index).collect()
        }
        false => picture.as_raw().clone(),
    };
    let mut writer = encoder.write_header().expect("it is written into memory");
    writer.write_image_data(&data).expect("it is written into memory");
    writer.finish().expect("it is written into memory");
    bytes
}
