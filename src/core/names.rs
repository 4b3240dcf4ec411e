//! Enums whose variants have names.

/// Declares an enum whose variants have names in files, in scripts and on the command line, and may have labels in
/// panels:
///
/// ```text
/// enum FovAxis { X = "x" => "horizontal", Y = "y" => "vertical" }
/// ```
///
/// From the declaration follow `ALL`, `name`, `of_name` and, with labels, `label` and `LABELED`.
#[macro_export]
macro_rules! declare_names {
    ($(#[$meta:meta])* $vis:vis enum $Family:ident {
        $($(#[$doc:meta])* $Variant:ident = $name:literal => $label:literal),* $(,)?
    }) => {
        $crate::declare_names! {
            $(#[$meta])*
            $vis enum $Family { $($(#[$doc])* $Variant = $name),* }
        }

        #[allow(dead_code, reason = "some families need a part of it only")]
        impl $Family {
            /// All variants with their labels.
            pub const LABELED: [(Self, &'static str); Self::ALL.len()] = [$((Self::$Variant, $label)),*];

            /// The label in panels.
            pub const fn label(self) -> &'static str {
                match self {
                    $(Self::$Variant => $label,)*
                }
            }
        }
    };
    ($(#[$meta:meta])* $vis:vis enum $Family:ident {
        $($(#[$doc:meta])* $Variant:ident = $name:literal),* $(,)?
    }) => {
        $(#[$meta])*
        $vis enum $Family { $($(#[$doc])* $Variant,)* }

        #[allow(dead_code, reason = "some families need a part of it only")]
        impl $Family {
            /// All variants, in the order of their declaration.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$Variant),*];

            /// The name in files, in scripts and on the command line.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$Variant => $name,)*
                }
            }

            /// The variant of this name; None if there is none.
            pub fn of_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|known| known.name() == name)
            }
        }
    };
}
