//! The pipette: a field asks for a colour of the picture, and the next click in the picture gives it.

use bevy_egui::egui::{Context, Id};

use crate::color::Rgb;

/// The field that waits for a colour.
#[derive(Clone, Copy)]
struct Waiting(Id);

/// The colour for a field.
#[derive(Clone, Copy)]
struct Given {
    field: Id,
    color: Rgb,
}

/// Waits for a colour for this field, and for no other one any more.
pub fn begin(context: &Context, field: Id) {
    context.data_mut(|data| data.insert_temp(Id::NULL, Waiting(field)));
}

/// Whether a field waits for a colour.
pub fn is_waiting(context: &Context) -> bool {
    context.data(|data| data.get_temp::<Waiting>(Id::NULL)).is_some()
}

/// Ends the wait without a colour.
pub fn cancel(context: &Context) {
    context.data_mut(|data| data.remove::<Waiting>(Id::NULL));
}

/// Gives a colour to the field that waits: linear Rec. 709.
pub fn give(context: &Context, color: Rgb) {
    context.data_mut(|data| {
        if let Some(Waiting(field)) = data.get_temp(Id::NULL) {
            data.remove::<Waiting>(Id::NULL);
            data.insert_temp(Id::NULL, Given { field, color });
        }
    });
    context.request_repaint();
}

/// The colour that was given to this field, once.
pub fn take(context: &Context, field: Id) -> Option<Rgb> {
    let given: Given = context.data(|data| data.get_temp(Id::NULL))?;
    if given.field != field {
        return None;
    }
    context.data_mut(|data| data.remove::<Given>(Id::NULL));
    Some(given.color)
}

#[cfg(test)]
mod tests {
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
    }
}
