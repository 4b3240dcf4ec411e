//! Edits textures, and keeps common parameters when the kind of a texture changes.

use bevy::math::{Affine2, Vec2};
use bevy_egui::egui::{self, Ui};

use super::caption::Caption;
use super::fields::{self, NumberStyle};
use super::plain_value::PlainValue;
use crate::app::editor::command::texture_placing::Placing;
use crate::color::Rgb;
use crate::scene::texture_parameters::{FILTER_TYPE, NAME, RAW, TO_UV, WRAP_MODE, WRAP_MODE_V};
use crate::scene::{
    Bitmap, Declared, Parameter, ParameterMut, ParameterRef, Pattern, Texture, TextureFilter, TextureWrap,
};

/// The kind of value that a parameter has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TextureKind {
    /// The parameter has no texture.
    Plain,
    Bitmap,
    Checkerboard,
    MeshAttribute,
    /// The pattern of this plugin.
    Pattern(&'static str),
}

impl TextureKind {
    /// All kinds, in the order of menus.
    pub fn all() -> impl Iterator<Item = Self> {
        [Self::Plain, Self::Bitmap, Self::Checkerboard, Self::MeshAttribute]
            .into_iter()
            .chain(Pattern::PLUGINS.into_iter().map(Self::Pattern))
    }

    pub fn of(texture: &Texture) -> Self {
        match texture {
            Texture::Bitmap(_) => Self::Bitmap,
            Texture::Checkerboard { .. } => Self::Checkerboard,
            Texture::MeshAttribute { .. } => Self::MeshAttribute,
            Texture::Pattern(pattern) => Self::Pattern(pattern.plugin()),
        }
    }

    /// The name in menus; `plain` is the name without a texture.
    pub fn name(self, plain: &'static str) -> &'static str {
        match self {
            Self::Plain => plain,
            Self::Bitmap => "picture\u{2026}",
            Self::Checkerboard => "checkerboard",
            Self::MeshAttribute => "values of the mesh",
            Self::Pattern(plugin) => Pattern::label(plugin),
        }
    }
}

/// Turns the parameter into a texture of another kind, or into none. Colours and the placing stay if both kinds have
/// them. A texture does not become a bitmap here, which needs a file first.
pub(crate) fn switch<T: PlainValue>(value: &mut Parameter<T>, kind: TextureKind, otherwise: T) {
    let (color, to_uv) = match &*value {
        Parameter::Constant(plain) => (Some(plain.to_color()), Affine2::IDENTITY),
        Parameter::Texture(Texture::Bitmap(bitmap)) => (None, bitmap.to_uv),
        Parameter::Texture(Texture::Checkerboard { color0, to_uv, .. }) => (color0.constant(), **to_uv),
        Parameter::Texture(Texture::MeshAttribute { .. }) => (None, Affine2::IDENTITY),
        Parameter::Texture(Texture::Pattern(pattern)) => parts(pattern),
    };
    match kind {
        TextureKind::Plain => *value = Parameter::Constant(color.map_or(otherwise, T::of_color)),
        TextureKind::Bitmap => {}
        TextureKind::Checkerboard => {
            *value = Parameter::Texture(Texture::Checkerboard {
                // The second colour is the format's default.
                color0: Box::new(color.unwrap_or(Rgb::splat(0.4)).into()),
                color1: Box::new(Rgb::splat(0.2).into()),
                to_uv: Box::new(to_uv),
            });
        }
        TextureKind::MeshAttribute => {
            *value = Parameter::Texture(Texture::MeshAttribute {
                name: "vertex_color".to_owned(),
                scale: 1.0,
                times: None,
            });
        }
        TextureKind::Pattern(plugin) => {
            if let Some(pattern) = Pattern::of_plugin(plugin) {
                *value = Parameter::Texture(Texture::Pattern(Box::new(with_parts(pattern, color, to_uv))));
            }
        }
    }
}

/// The first colour of a pattern, if it is one, and its placing.
fn parts(pattern: &Pattern) -> (Option<Rgb>, Affine2) {
    let (mut first, mut to_uv) = (None, Affine2::IDENTITY);
    pattern.visit(&mut |_, value| match value {
        ParameterRef::Nested(nested) if first.is_none() => first = Some(nested.constant()),
        ParameterRef::Placing(own) => to_uv = *own,
        _ => {}
    });
    (first.flatten(), to_uv)
}

/// The pattern with this first colour, if there is one, and this placing.
fn with_parts(mut pattern: Pattern, mut color: Option<Rgb>, to_uv: Affine2) -> Pattern {
    pattern.visit_mut(&mut |_, value| match value {
        ParameterMut::Nested(nested) => {
            if let Some(color) = color.take() {
                *nested = color.into();
            }
        }
        ParameterMut::Placing(own) => *own = to_uv,
        _ => {}
    });
    pattern
}

/// Shows the rows of a bitmap; returns true if edited.
pub(crate) fn bitmap(ui: &mut Ui, bitmap: &mut Bitmap) -> bool {
    let filters = [
        (TextureFilter::Bilinear, "bilinear"),
        (TextureFilter::Nearest, "nearest pixel"),
    ];
    let wraps = TextureWrap::ALL.map(|wrap| (wrap, wrap.name()));
    let mut changed = fields::choice(ui, &FILTER_TYPE, &mut bitmap.filter, &filters);
    changed |= fields::choice(ui, &WRAP_MODE, &mut bitmap.wrap, &wraps);
    if let Some(wrap) = &mut bitmap.wrap_v {
        changed |= fields::choice(ui, &WRAP_MODE_V, wrap, &wraps);
    }
    changed |= fields::checkbox(ui, &RAW, &mut bitmap.raw);
    placing(ui, &mut bitmap.to_uv) || changed
}

/// Shows repeats, rotation and offset of uv, and the shear if there is one; returns true if edited.
pub(crate) fn placing(ui: &mut Ui, to_uv: &mut Affine2) -> bool {
    let caption = Caption::from(&TO_UV);
    let Some(before) = Placing::of(to_uv) else {
        fields::note(ui, caption, "without extent, as in the file");
        return false;
    };
    let mut placing = before;
    let (mut scaling, mut shift) = (before.repeats.to_array(), before.offset.to_array());
    let style = NumberStyle::new;
    let pair = |speed| [style("U", speed), style("V", speed)];
    let mut changed = fields::numbers(ui, caption.titled("Repeats"), &mut scaling, pair(0.02));
    changed |= fields::angle_slider(ui, caption.titled("Rotation"), &mut placing.degrees, -180.0..=180.0);
    changed |= fields::numbers(ui, caption.titled("Offset"), &mut shift, pair(0.005));
    if before.shear != 0.0 {
        changed |= fields::number(
            ui,
            caption.titled("Shear"),
            &mut placing.shear,
            0.01,
            f32::MIN..=f32::MAX,
        );
    }
    if changed {
        // A scale of zero could not be undone by another one.
        placing.repeats = Vec2::from_array(scaling).map(|s| if s.abs() < 1e-4 { 1e-4 } else { s });
        placing.offset = Vec2::from_array(shift);
        *to_uv = placing.to_uv();
    }
    changed
}

/// Shows the name of a mesh attribute; returns true if edited.
pub(crate) fn mesh_attribute(ui: &mut Ui, name: &mut String) -> bool {
    let mut copy = name.clone();
    let changed = fields::row(ui, &NAME, |ui| {
        let width = ui.available_width() - 8.0;
        ui.add(egui::TextEdit::singleline(&mut copy).desired_width(width))
    })
    .changed();
    fields::write_back(changed, name, copy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_of_another_kind_keeps_what_both_have() {
        let red = Rgb::new(0.6, 0.1, 0.1);
        let mut value = Parameter::Constant(red);
        switch(&mut value, TextureKind::Checkerboard, Rgb::ONE);
        let Parameter::Texture(Texture::Checkerboard { color0, to_uv, .. }) = &mut value else {
            panic!("{value:?}")
        };
        assert_eq!(**color0, red.into());
        **to_uv = Affine2::from_scale(Vec2::splat(4.0));
        switch(&mut value, TextureKind::Plain, Rgb::ONE);
        assert_eq!(value, red.into());

        let placed = Bitmap {
            to_uv: Affine2::from_angle(0.5),
            ..Bitmap::default()
        };
        let mut roughness = Parameter::<f32>::Texture(Texture::Bitmap(Box::new(placed)));
        switch(&mut roughness, TextureKind::Checkerboard, 0.3);
        let Parameter::Texture(Texture::Checkerboard { to_uv, .. }) = &roughness else {
            panic!("{roughness:?}")
        };
        assert_eq!(**to_uv, Affine2::from_angle(0.5));
        let mut attribute = Parameter::<f32>::Constant(0.1);
        switch(&mut attribute, TextureKind::MeshAttribute, 0.3);
        switch(&mut attribute, TextureKind::Plain, 0.3);
        assert_eq!(attribute, 0.3.into());
    }
}
