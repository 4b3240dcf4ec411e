//! The captions of the parts of a divided picture.

use crate::app::editor::command::compare_view::CompareView;

/// A text, and the middle of the part of the picture that it labels, as a share of the width.
pub type Caption = (f32, &'static str);

/// The captions of the picture's parts. A comparison with a snapshot covers the thirds of
/// [`crate::engine::RenderControl::strategy_split`], which have captions only without it. `is_of_other_scene`: the
/// snapshot is of a scene that was open before.
pub fn captions(split: bool, compared: CompareView, is_of_other_scene: bool) -> Vec<Caption> {
    let (snapshot, difference) = match is_of_other_scene {
        false => ("snapshot", "difference from the snapshot"),
        true => (
            "snapshot of another scene",
            "difference from the snapshot of another scene",
        ),
    };
    match (compared, split) {
        (CompareView::Wipe(at), _) => vec![(0.5 * at, snapshot), (0.5 + 0.5 * at, "now")],
        (CompareView::Noisy(at), _) => vec![(0.5 * at, "as sampled"), (0.5 + 0.5 * at, "denoised")],
        (CompareView::Baked(at), _) => vec![(0.5 * at, "lightmaps"), (0.5 + 0.5 * at, "path traced")],
        (CompareView::Difference, _) => vec![(0.5, difference)],
        (CompareView::Off, true) => vec![
            (1.0 / 6.0, "BSDF sampling"),
            (0.5, "light sampling"),
            (5.0 / 6.0, "both (MIS)"),
        ],
        (CompareView::Off, false) => Vec::new(),
    }
}
