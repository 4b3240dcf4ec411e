//! The captions of the parts of a divided picture.

use crate::app::editor::command::compare_view::CompareView;

/// Words, and the middle of the part of the picture's width that they are about.
pub type Caption = (f32, &'static str);

/// The captions of the picture's parts. A comparison with a snapshot covers the thirds of [`crate::engine::RenderControl::strategy_split`], which
/// have captions only without it.
pub fn captions(split: bool, compared: CompareView) -> Vec<Caption> {
    match (compared, split) {
        (CompareView::Wipe(at), _) => vec![(0.5 * at, "snapshot"), (0.5 + 0.5 * at, "now")],
        (CompareView::Noisy(at), _) => vec![(0.5 * at, "as sampled"), (0.5 + 0.5 * at, "denoised")],
        (CompareView::Baked(at), _) => vec![(0.5 * at, "lightmaps"), (0.5 + 0.5 * at, "path traced")],
        (CompareView::Difference, _) => vec![(0.5, "difference from the snapshot")],
        (CompareView::Off, true) => vec![
            (1.0 / 6.0, "BSDF sampling"),
            (0.5, "light sampling"),
            (5.0 / 6.0, "both (MIS)"),
        ],
        (CompareView::Off, false) => Vec::new(),
    }
}
