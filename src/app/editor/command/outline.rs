//! Edits of the outliner: names, order, groups, and the marks of hidden and locked things.

use bevy::prelude::Entity;

use super::traits::Traits;

/// An edit of the names, the order, the groups and the marks of things, as the outliner shows them.
#[derive(Clone, Debug, PartialEq)]
pub enum OutlineEdit {
    /// Renames a thing. An empty name removes its name.
    Rename(Entity, String),
    /// Puts things, in this order, before another of their kind, or last.
    Reorder {
        /// The things, all of one kind.
        moved: Vec<Entity>,
        /// The thing before which they are put; None for the end of the list.
        before: Option<Entity>,
    },
    /// Puts the selection into a folder of its own, with a transform of its own.
    Group,
    /// Moves the members of the selected groups out of them, and deletes the groups.
    Ungroup,
    /// Puts things into the folder of this path, or out of all.
    PutInto {
        /// The things.
        things: Vec<Entity>,
        /// The names of folders, from the outermost on, with `/` between.
        folder: Option<String>,
    },
    /// Hides these things, or shows them again.
    Hide(Vec<Entity>, bool),
    /// Hides all shapes and lights except the selected ones.
    HideOthers,
    /// Shows everything that is hidden.
    ShowAll,
    /// Protects these things from edits and clicks in the picture, or ends that.
    Lock(Vec<Entity>, bool),
}

impl OutlineEdit {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Rename(thing, name) => Traits::edit("Rename").of(&[*thing]).giving_name(name).keeping_picture(),
            Self::Reorder { moved, .. } => Traits::edit("Reorder").of(moved),
            Self::Group => Traits::edit("Group").of_selection().keeping_picture(),
            Self::Ungroup => Traits::edit("Ungroup").of_selection().keeping_picture(),
            Self::PutInto { things, .. } => Traits::edit("Put into folder").of(things).keeping_picture(),
            Self::Hide(things, true) => Traits::edit("Hide").of(things),
            Self::Hide(things, false) => Traits::edit("Show").of(things),
            Self::HideOthers => Traits::edit("Hide others"),
            Self::ShowAll => Traits::edit("Show"),
            Self::Lock(things, true) => Traits::edit("Lock").of(things).keeping_picture(),
            Self::Lock(things, false) => Traits::edit("Unlock").of(things).keeping_picture(),
        }
    }
}
