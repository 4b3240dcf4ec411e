//! Reports to egui that the pointer has left the window, which `bevy_egui` does not. Otherwise the widget under it
//! would stay highlighted.

use bevy::prelude::*;
use bevy::window::{CursorLeft, PrimaryWindow};
use bevy_egui::EguiInput;
use bevy_egui::egui::Event;

/// Reports to egui that the pointer has left the window. Runs after egui's events have been gathered and before egui
/// gets them. A drag continues outside of the window.
pub fn note_pointer_gone(
    mut left: MessageReader<CursorLeft>,
    windows: Query<&Window, With<PrimaryWindow>>,
    buttons: Res<ButtonInput<MouseButton>>,
    mut inputs: Query<&mut EguiInput>,
) {
    let is_back = windows.iter().any(|window| window.cursor_position().is_some());
    if left.read().count() == 0 || is_back || buttons.get_pressed().len() > 0 {
        return;
    }
    for mut input in &mut inputs {
        input.0.events.push(Event::PointerGone);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_told_once_and_not_in_a_drag() {
        let mut world = World::new();
        world.init_resource::<Messages<CursorLeft>>();
        world.init_resource::<ButtonInput<MouseButton>>();
        let window = world.spawn((Window::default(), PrimaryWindow)).id();
        let context = world.spawn(EguiInput::default()).id();
        let system = world.register_system(note_pointer_gone);
        let told = |world: &mut World| {
            world.run_system(system).expect("runs");
            let mut input = world.get_mut::<EguiInput>(context).expect("a context");
            std::mem::take(&mut input.0.events)
        };
        assert_eq!(told(&mut world), []);
        world.write_message(CursorLeft { window });
        assert_eq!(told(&mut world), [Event::PointerGone]);
        assert_eq!(told(&mut world), []);
        world
            .resource_mut::<ButtonInput<MouseButton>>()
            .press(MouseButton::Left);
        world.write_message(CursorLeft { window });
        assert_eq!(told(&mut world), []);
    }
}
