//! The sizes of selected things along the axes of the world.

use bevy::math::Affine3A;
use bevy_egui::egui::Ui;

use super::caption::Caption;
use super::fields::{self, NumberStyle};
use super::lengths;
use crate::app::editor::camera::sizing::{axes_of, scaled};
use crate::app::editor::model::Sizes;
use crate::math::Aabb;
use crate::scene::Shape;

/// Shows the extents of a box. A new extent scales `to_world` about the middle of the box, so that the box gets that
/// extent. Returns true if edited. Without a pose, or if it is turned, the numbers are only shown.
pub(super) fn dimensions(ui: &mut Ui, bounds: &Aabb, to_world: Option<&mut Affine3A>, shape: Option<&Shape>) -> bool {
    let extent = bounds.extent();
    let scalable = to_world.filter(|pose| shape.is_some() && axes_of(&pose.matrix3).is_some());
    let Some(to_world) = scalable else {
        let unit = lengths::unit(ui);
        let [x, y, z] = extent.to_array().map(|extent| unit.number(extent));
        let text = format!("{x} × {y} × {z}{}", unit.sign());
        fields::note(ui, "Size", text);
        return false;
    };
    let mut edited = extent;
    let speed = 0.005 * extent.max_element().max(1e-3);
    if !lengths::vector(ui, "Size", &mut edited, speed) {
        return false;
    }
    match scaled(to_world, bounds, edited, shape) {
        Some(pose) => *to_world = pose,
        None => return false,
    }
    true
}

/// Shows the sizes of several things along each axis, or that they differ. Returns the axis and the new size for each
/// of them if edited.
pub(super) fn sizes(ui: &mut Ui, sizes: &Sizes) -> Option<(usize, f32)> {
    let caption = Caption::from("Size").explained(
        "A number is the size of each selected thing along that axis of the world, about its own middle. Turned shapes keep their size.",
    );
    let active = sizes.active.to_array();
    // If the things differ, the number of the active one is an edit, too, and has to differ from the one before.
    let mut numbers = [0, 1, 2].map(|axis| {
        if sizes.is_common[axis] {
            active[axis]
        } else {
            active[axis].next_up()
        }
    });
    let before = numbers;
    let speed = 0.005 * sizes.active.max_element().max(1e-3);
    let styles = [0, 1, 2].map(|axis| NumberStyle {
        text: (!sizes.is_common[axis]).then_some("mixed"),
        ..NumberStyle::new(["X", "Y", "Z"][axis], speed)
    });
    if !lengths::numbers(ui, caption, &mut numbers, styles) {
        return None;
    }
    (0..3)
        .find(|axis| numbers[*axis] != before[*axis])
        .map(|axis| (axis, numbers[axis]))
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3;
    use bevy_egui::egui::{Event, vec2};
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    use super::*;

    #[test]
    fn sizes_that_differ_are_mixed_and_the_active_one_can_be_typed_for_all() {
        let shown = Sizes {
            active: Vec3::new(9.0, 2.0, 1.0),
            is_common: [false, true, true],
        };
        let mut harness = Harness::builder().with_size(vec2(400.0, 100.0)).build_ui_state(
            move |ui: &mut Ui, edits: &mut Vec<(usize, f32)>| edits.extend(sizes(ui, &shown)),
            Vec::new(),
        );
        harness.run_steps(3);
        assert_eq!(harness.query_all_by_value("mixed").count(), 1);
        harness.get_by_label("Size X").click();
        harness.run_steps(3);
        harness.event(Event::Text("9".to_owned()));
        harness.run_steps(2);
        harness.ctx.memory_mut(|memory| memory.stop_text_input());
        harness.run_steps(3);
        assert_eq!(harness.state().last(), Some(&(0, 9.0)));
    }
}
