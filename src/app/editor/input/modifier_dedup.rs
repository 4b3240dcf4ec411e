//! Drops repeated reports of the modifier keys, so that the window sleeps while nothing happens: `bevy_egui` reports
//! the modifiers in every frame, whether they changed or not, and egui draws once more after every event.

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;
use bevy_egui::EguiInput;
use bevy_egui::egui::{Event, Modifiers};

/// Removes the reports of modifiers that equal the last ones. Runs after egui's events have been gathered and before
/// egui gets them.
pub fn drop_repeated_modifiers(
    mut inputs: Query<(Entity, &mut EguiInput)>,
    mut known: Local<EntityHashMap<Modifiers>>,
) {
    for (window, mut input) in &mut inputs {
        let known = known.entry(window).or_default();
        input.0.events.retain(|event| match event {
            Event::ModifiersChanged(now) => std::mem::replace(known, *now) != *now,
            _ => true,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_changes_are_reported() {
        let mut world = World::new();
        let window = world.spawn(EguiInput::default()).id();
        let system = world.register_system(drop_repeated_modifiers);
        let mut told = |modifiers: Modifiers| {
            let mut input = world.get_mut::<EguiInput>(window).expect("a window");
            input.0.events = vec![Event::ModifiersChanged(modifiers), Event::Copy];
            world.run_system(system).expect("runs");
            let events = world.get::<EguiInput>(window).map(|input| input.0.events.clone());
            events.unwrap_or_default()
        };
        assert_eq!(told(Modifiers::NONE), [Event::Copy]);
        let pressed = [Event::ModifiersChanged(Modifiers::SHIFT), Event::Copy];
        assert_eq!(told(Modifiers::SHIFT), pressed);
        assert_eq!(told(Modifiers::SHIFT), [Event::Copy]);
        assert_eq!(told(Modifiers::NONE)[0], Event::ModifiersChanged(Modifiers::NONE));
    }
}
