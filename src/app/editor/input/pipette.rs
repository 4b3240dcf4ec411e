//! The pipette: a field asks for a colour of the picture, and the next click in the picture gives it. A field that is
//! no longer shown asks for nothing.

use bevy_egui::egui::{Context, Id};

use crate::color::Rgb;

/// The field that wants a colour.
#[derive(Clone, Copy)]
struct Wanted {
    field: Id,
    /// The number of the pass in which the field was last shown.
    shown: u64,
    /// The colour for the field, once it is given.
    color: Option<Rgb>,
}

/// The field that wants a colour, if it was shown in this pass or in the one before.
fn wanted(context: &Context) -> Option<Wanted> {
    let wanted: Wanted = context.data(|data| data.get_temp(Id::NULL))?;
    let passes = context.cumulative_pass_nr().saturating_sub(wanted.shown);
    Some(wanted).filter(|_| passes <= 1)
}

fn set(context: &Context, wanted: Wanted) {
    context.data_mut(|data| data.insert_temp(Id::NULL, wanted));
}

/// Waits for a colour for this field, and for no other one any more.
pub fn begin(context: &Context, field: Id) {
    let wanted = Wanted {
        field,
        shown: context.cumulative_pass_nr(),
        color: None,
    };
    set(context, wanted);
}

/// Whether a field waits for a colour.
pub fn is_waiting(context: &Context) -> bool {
    wanted(context).is_some_and(|wanted| wanted.color.is_none())
}

/// Ends the wait without a colour.
pub fn cancel(context: &Context) {
    context.data_mut(|data| data.remove::<Wanted>(Id::NULL));
}

/// Gives a colour to the field that waits: linear Rec. 709.
pub fn give(context: &Context, color: Rgb) {
    if let Some(wanted) = wanted(context) {
        let color = Some(color);
        set(context, Wanted { color, ..wanted });
    }
    context.request_repaint();
}

/// The colour that was given to this field, once. Fields call this whenever they are shown.
pub fn take(context: &Context, field: Id) -> Option<Rgb> {
    let wanted = wanted(context).filter(|wanted| wanted.field == field)?;
    match wanted.color {
        Some(_) => cancel(context),
        None => begin(context, field),
    }
    wanted.color
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::RawInput;

    use super::*;

    #[test]
    fn a_colour_goes_once_to_the_field_that_asked_for_it() {
        let (context, [one, other]) = (Context::default(), ["one", "other"].map(Id::new));
        give(&context, Rgb::ONE);
        assert_eq!(take(&context, one), None, "nobody has asked");
        begin(&context, one);
        begin(&context, other);
        assert!(is_waiting(&context));
        give(&context, Rgb::ONE);
        assert!(!is_waiting(&context));
        assert_eq!(
            [take(&context, one), take(&context, other), take(&context, other)],
            [None, Some(Rgb::ONE), None]
        );
        begin(&context, one);
        cancel(&context);
        give(&context, Rgb::ONE);
        assert_eq!(take(&context, one), None);
        // A colour that was not taken is not for the next time.
        begin(&context, one);
        give(&context, Rgb::ONE);
        begin(&context, one);
        assert_eq!(take(&context, one), None);
    }

    /// Passes without anything shown.
    fn pass(context: &Context, count: usize) {
        for _ in 0..count {
            context.begin_pass(RawInput::default());
            let _ = context.end_pass();
        }
    }

    #[test]
    fn a_field_that_is_hidden_no_longer_waits() {
        let (context, field) = (Context::default(), Id::new("field"));
        begin(&context, field);
        for _ in 0..5 {
            pass(&context, 1);
            assert_eq!(take(&context, field), None);
        }
        pass(&context, 1);
        assert!(is_waiting(&context), "the picture may be shown before the field");
        pass(&context, 1);
        assert!(!is_waiting(&context));
        give(&context, Rgb::ONE);
        assert_eq!(take(&context, field), None);
        // The same for a colour that was given just before the field was hidden.
        begin(&context, field);
        give(&context, Rgb::ONE);
        pass(&context, 2);
        assert_eq!(take(&context, field), None);
    }
}
