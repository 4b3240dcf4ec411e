//! Rows of the parameters of participating media.

use bevy::math::{Affine3A, Vec3};
use bevy_egui::egui::Ui;

use super::caption::Caption;
use super::color_field;
use super::fields::{self, NumberStyle};
use super::lengths;
use super::light_strength::StrengthUnits;
use super::material::Rows;
use crate::app::editor::model::panel_textures::PanelTextures;
use crate::app::editor::model::{InspectedGrid, InspectedMedium};
use crate::app::editor::words::figures::length;
use crate::color::Rgb;
use crate::scene::medium::{ALBEDO, SIGMA_A, SIGMA_S, SIGMA_T};
use crate::scene::{
    Coefficients, Declared, GridFile, Medium, ParameterInfo, PhaseFunction, VolumeFilter, VolumeFormat,
    VolumeParameter, VolumeWrap,
};

/// The names of the rows that are no parameters of the format.
const FREE_PATH: &str = "Free path";
const PHASE: &str = "Phase";
const GRID_NAME: &str = "Name";

/// Shows the rows of a medium; returns true if edited.
pub(super) fn medium(ui: &mut Ui, edited: &mut Medium, shown: &InspectedMedium, textures: &PanelTextures) -> bool {
    let mut changed = false;
    let mut rows = Rows::new(ui, textures);
    edited.visit_mut(&mut |info, value| rows.parameter(info, value));
    changed |= rows.edit.changed;
    changed |= free_path(ui, edited);
    changed |= phase(ui, &mut edited.phase, textures);
    let grids: Vec<Option<InspectedGrid>> = shown.grids.iter().map(|(_, content)| *content).collect();
    changed | volumes(ui, edited, &grids)
}

/// The mean free path by colour, which is the inverse of the extinction. That of a grid varies, and has no row.
fn free_path(ui: &mut Ui, medium: &mut Medium) -> bool {
    let Some(path) = medium.mean_free_path() else {
        return false;
    };
    let mut lengths = path.to_array();
    let speed = 0.01 * lengths.into_iter().filter(|it| it.is_finite()).fold(1e-3, f32::max);
    let styles = ["R", "G", "B"].map(|letter| NumberStyle {
        range: f32::MIN_POSITIVE..=f32::MAX,
        ..NumberStyle::new(letter, speed)
    });
    let about = "How far light goes on average before it is scattered or absorbed, by colour: the inverse of the extinction times the density. \
                 Over this way the share exp(-1), 37 %, is left. \u{221e}: it takes nothing out.";
    let caption = Caption::from(&SIGMA_T).titled(FREE_PATH).explained(about);
    if !lengths::numbers(ui, caption, &mut lengths, styles) {
        return false;
    }
    medium.set_mean_free_path(Rgb::from_array(lengths));
    true
}

/// Shows the kind of the phase function and its parameters; returns true if edited.
fn phase(ui: &mut Ui, phase: &mut PhaseFunction, textures: &PanelTextures) -> bool {
    let info = phase.info();
    let is_blend = |name: &str| name == "blendphase";
    let mut wanted = info.name;
    let about = "The directions in which light goes on that is scattered.";
    let caption = Caption::from((PHASE, "phase")).explained(about);
    let mut changed = false;
    if is_blend(info.name) {
        fields::note(ui, caption, info.label);
    } else {
        let plugins = PhaseFunction::DECLARED.iter().filter(|other| !is_blend(other.name));
        let options: Vec<_> = plugins.map(|plugin| (plugin.name, plugin.label)).collect();
        if fields::choice(ui, caption, &mut wanted, &options)
            && let Some(turned) = PhaseFunction::of_plugin(wanted)
        {
            *phase = turned;
            changed = true;
        }
    }
    let mut rows = Rows::new(ui, textures);
    phase.visit_mut(&mut |info, value| rows.parameter(info, value));
    changed |= rows.edit.changed;
    if let PhaseFunction::Blend(blend) = phase {
        for (number, inner) in blend.of.iter_mut().enumerate() {
            ui.push_id(number, |ui| {
                let label = inner.info().label;
                fields::note(ui, ["First", "Second"][number], label);
                let mut rows = Rows::new(ui, textures);
                if !matches!(inner, PhaseFunction::Blend(_)) {
                    inner.visit_mut(&mut |info, value| rows.parameter(info, value));
                }
                changed |= rows.edit.changed;
            });
        }
    }
    changed
}

/// Shows the places of volumes, and the contents of grid files; returns true if edited. `grids` are in the order of
/// [`Medium::for_each_grid`].
fn volumes(ui: &mut Ui, medium: &mut Medium, grids: &[Option<InspectedGrid>]) -> bool {
    let mut changed = false;
    let mut grids = grids.iter().copied();
    let mut show = |ui: &mut Ui, title: &str, volume: Volume| {
        ui.push_id(title, |ui| match volume {
            Volume::Box(to_world) => changed |= place(ui, title, to_world),
            Volume::Grid(grid) => {
                let content = grids.next().flatten();
                changed |= grid_rows(ui, title, grid, content);
            }
            Volume::Everywhere => {}
        });
    };
    if let Coefficients::Extinction { sigma_t, albedo } = &mut medium.coefficients {
        show(ui, SIGMA_T.label, Volume::of(sigma_t));
        show(ui, ALBEDO.label, Volume::of(albedo));
    }
    show(ui, "Emission", Volume::of(&mut medium.emission));
    medium
        .phase
        .for_each_volume_mut(&mut |weight| show(ui, "Weight", Volume::of(weight)));
    changed
}

/// The transform of a volume, whatever the type of its values.
enum Volume<'v> {
    Everywhere,
    Box(&'v mut Affine3A),
    Grid(&'v mut GridFile),
}

impl<'v> Volume<'v> {
    fn of<T>(volume: &'v mut VolumeParameter<T>) -> Self {
        match volume {
            VolumeParameter::Constant(_) => Self::Everywhere,
            VolumeParameter::Box { to_world, .. } => Self::Box(to_world),
            VolumeParameter::Grid(grid) => Self::Grid(grid),
        }
    }
}

fn grid_rows(ui: &mut Ui, title: &str, grid: &mut GridFile, content: Option<InspectedGrid>) -> bool {
    ui.add_space(4.0);
    ui.weak(format!("The grid of {}", title.to_lowercase()));
    let size = match content {
        Some(content) => {
            let [x, y, z] = content.resolution.to_array();
            let values = if content.channels == 1 { "" } else { ", coloured" };
            format!("{x} \u{d7} {y} \u{d7} {z}{values}")
        }
        None => "not loaded".to_owned(),
    };
    fields::note(ui, "Voxels", size);
    if let Some(content) = content {
        let [from, to] = corners(&(grid.to_world * content.world_from_local));
        fields::note(ui, "From", from);
        fields::note(ui, "To", to);
    }
    let filters = VolumeFilter::ALL.map(|filter| (filter, filter.name()));
    let mut changed = false;
    if let VolumeFormat::Vdb { grid: name } = &mut grid.format {
        changed |= name_of_grid(ui, name);
    }
    changed |= fields::choice(ui, "Filter", &mut grid.filter, &filters);
    // The plugin of `.vdb` files has neither parameter.
    if grid.format == VolumeFormat::Vol {
        let wraps = VolumeWrap::ALL.map(|wrap| (wrap, wrap.name()));
        changed |= fields::choice(ui, "Outside", &mut grid.wrap, &wraps);
        if grid.use_grid_bbox || content.is_some_and(|content| content.bounds.is_some()) {
            changed |= fields::checkbox(ui, "Box of file", &mut grid.use_grid_bbox);
        }
    }
    place(ui, "Grid", &mut grid.to_world) || changed
}

/// The corners of the bounds of a grid in the world, as texts. `to_world` is applied to the unit cube.
fn corners(to_world: &Affine3A) -> [String; 2] {
    let cube = [0, 1, 2, 3, 4, 5, 6, 7]
        .map(|corner| Vec3::new((corner & 1) as f32, (corner >> 1 & 1) as f32, (corner >> 2) as f32));
    let placed = cube.map(|corner| to_world.transform_point3(corner));
    let (min, max) = placed.iter().fold((placed[0], placed[0]), |(min, max), corner| {
        (min.min(*corner), max.max(*corner))
    });
    [min, max].map(|corner| corner.to_array().map(length).join(", "))
}

/// Shows the name of the grid in a `.vdb` file. A typed name counts once the field loses the focus.
fn name_of_grid(ui: &mut Ui, name: &mut Option<String>) -> bool {
    let mut text = name.clone().unwrap_or_default();
    let about = "The grid of the file. Empty: `density`, or else the only one.";
    let is_chosen = fields::text(ui, Caption::from((GRID_NAME, "grid")).explained(about), &mut text);
    if is_chosen {
        *name = (!text.is_empty()).then_some(text);
    }
    is_chosen
}

/// Shows the corner and the size of a volume, which is the unit cube under this transform.
fn place(ui: &mut Ui, title: &str, to_world: &mut Affine3A) -> bool {
    let axes = to_world.matrix3.to_cols_array_2d().map(Vec3::from_array);
    let mut size = Vec3::from_array(axes.map(Vec3::length));
    let speed = 0.01 * size.max_element().max(1e-3);
    let mut corner = Vec3::from(to_world.translation);
    let mut changed = false;
    if lengths::vector(ui, &format!("{title} at"), &mut corner, speed) && corner.is_finite() {
        to_world.translation = corner.into();
        changed = true;
    }
    let before = size;
    if lengths::vector(ui, &format!("{title} size"), &mut size, speed)
        && size.cmpgt(Vec3::ZERO).all()
        && size.is_finite()
    {
        let factor = size / before;
        if factor.is_finite() {
            to_world.matrix3.x_axis *= factor.x;
            to_world.matrix3.y_axis *= factor.y;
            to_world.matrix3.z_axis *= factor.z;
            changed = true;
        }
    }
    changed
}

/// Shows the rows of a quantity by colour. A medium has several, whose rows of colours have names of their own.
fn tinted(ui: &mut Ui, info: &'static ParameterInfo, unit: &str, value: &mut Rgb) -> bool {
    let caption = Caption::from(info);
    color_field::colored(
        ui,
        caption,
        caption.part(&format!("{} tint", info.label)),
        StrengthUnits::radiometric(unit),
        0.0,
        value,
    )
}

impl Rows<'_> {
    pub(super) fn coefficients(&mut self, value: &mut Coefficients) {
        match value {
            Coefficients::Extinction { sigma_t, albedo } => {
                self.volume(&ALBEDO, albedo, |rows, info, color| {
                    rows.edit.changed |= color_field::color(rows.ui, info, color);
                });
                self.volume(&SIGMA_T, sigma_t, Self::coefficient);
            }
            Coefficients::Separate { sigma_s, sigma_a } => {
                self.coefficient(&SIGMA_S, sigma_s);
                self.coefficient(&SIGMA_A, sigma_a);
            }
        }
    }

    pub(super) fn volume_emission(&mut self, info: &'static ParameterInfo, value: &mut VolumeParameter<Rgb>) {
        self.volume(info, value, |rows, info, color| {
            rows.edit.changed |= tinted(rows.ui, info, info.unit, color);
        });
    }

    pub(super) fn volume_share(&mut self, info: &'static ParameterInfo, value: &mut VolumeParameter<f32>) {
        self.volume(info, value, |rows, info, share| {
            rows.edit.changed |= fields::slider(rows.ui, info, share, info.slider_range());
        });
    }

    pub(super) fn values(&mut self, info: &'static ParameterInfo, values: &[f32]) {
        let text = format!("{} numbers", values.len());
        fields::note(self.ui, info, text);
    }

    /// Shows a colour, and its strength per unit of length.
    fn coefficient(&mut self, info: &'static ParameterInfo, value: &mut Rgb) {
        let unit = match lengths::unit(self.ui).name() {
            "" => String::new(),
            name => format!(" /{name}"),
        };
        if tinted(self.ui, info, &unit, value) {
            *value = value.clamp(Rgb::ZERO, Rgb::splat(*info.range.end()));
            self.edit.changed = true;
        }
    }

    /// Shows a homogeneous value; a grid is only named.
    fn volume<T>(
        &mut self,
        info: &'static ParameterInfo,
        value: &mut VolumeParameter<T>,
        row: impl FnOnce(&mut Self, &'static ParameterInfo, &mut T),
    ) {
        match value {
            VolumeParameter::Constant(value) | VolumeParameter::Box { value, .. } => row(self, info, value),
            VolumeParameter::Grid(grid) => {
                let name = grid.path.file_name().unwrap_or_default().to_string_lossy();
                fields::note(self.ui, info, name);
            }
        }
    }
}
