//! The macros by which the plugins of a family are declared, once each: name, parameters, defaults and help texts.
//!
//! From the declaration follow the type that holds the values, the list of all plugins, and the trait
//! [`Declared`](crate::scene::Declared), through which all others access the parameters: the reader and the writer of
//! files, panels, scripts and the checks of ranges.
//!
//! A declaring file has `Declared`, `ParameterInfo`, `ParameterRef`, `ParameterMut` and `PluginInfo` in scope.

use std::ops::RangeInclusive;

/// The declaration of a plugin except for its parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PluginInfo {
    /// The name in the file.
    pub name: &'static str,
    /// The name in lists.
    pub label: &'static str,
    /// The number of bsdfs nested in it.
    pub nested: RangeInclusive<usize>,
    /// Whether it always refracts, and so needs no `twosided`.
    pub refracts: bool,
}

impl PluginInfo {
    pub const fn new(name: &'static str, label: &'static str) -> Self {
        Self {
            name,
            label,
            nested: 0..=0,
            refracts: false,
        }
    }

    /// Sets the number of nested bsdfs.
    pub const fn nesting(mut self, count: RangeInclusive<usize>) -> Self {
        self.nested = count;
        self
    }

    /// Declares that light is refracted.
    pub const fn refracting(mut self) -> Self {
        self.refracts = true;
        self
    }
}

/// Declares a family of plugins as an enum:
///
/// ```text
/// [PLUGIN_INFO]
/// Variant { field: Type = DEFAULT => Kind(PARAMETER_INFO), ... },
/// [PLUGIN_INFO]
/// Variant(name: Type => as_mut),
/// ```
///
/// A kind is a variant of `ParameterRef` and `ParameterMut`. The second form is for parameters that are a struct of
/// their own: `as_mut` gives that from a reference to what the variant holds.
macro_rules! declare_plugins {
    ($($declaration:tt)*) => {
        $crate::scene::components::declare::declare_plugin_type! { $($declaration)* }
        $crate::scene::components::declare::declare_plugin_parameters! { $($declaration)* }
    };
}

/// The type of `declare_plugins` alone. The file of a type that parameters may hold does not know `ParameterRef`.
macro_rules! declare_plugin_type {
    ($(#[$meta:meta])* pub enum $Family:ident { $(
        $(#[$doc:meta])*
        [$plugin:expr]
        $Variant:ident
        $({ $($(#[$field_doc:meta])* $field:ident: $type:ty = $default:expr => $kind:ident($info:expr)),* $(,)? })?
        $(($inside:ident: $Inside:ty => $as_mut:path))?
    ),* $(,)? }) => {
        $(#[$meta])*
        #[allow(missing_docs, reason = "the declaration says what each plugin and parameter is")]
        pub enum $Family {
            $($(#[$doc])* $Variant $({ $($(#[$field_doc])* $field: $type),* })? $(($Inside))?,)*
        }
    };
}

/// The plugins of `declare_plugins` and their parameters, for a type that `declare_plugin_type` has declared.
macro_rules! declare_plugin_parameters {
    ($(#[$meta:meta])* pub enum $Family:ident { $(
        $(#[$doc:meta])*
        [$plugin:expr]
        $Variant:ident
        $({ $($(#[$field_doc:meta])* $field:ident: $type:ty = $default:expr => $kind:ident($info:expr)),* $(,)? })?
        $(($inside:ident: $Inside:ty => $as_mut:path))?
    ),* $(,)? }) => {
        impl $Family {
            /// The declarations of all plugins, in the order of lists.
            pub(crate) const DECLARED: &'static [PluginInfo] = &[$($plugin),*];
            /// The names of all plugins.
            pub const PLUGINS: [&'static str; Self::DECLARED.len()] = [$($plugin.name),*];

            /// The plugin of this name with default parameters; None if there is no such plugin.
            pub fn of_plugin(plugin: &str) -> Option<Self> {
                $(if plugin == const { $plugin.name } {
                    return Some(Self::$Variant $({ $($field: $default),* })? $((<$Inside>::default()))?);
                })*
                None
            }

            /// The declaration of its plugin.
            pub(crate) fn info(&self) -> &'static PluginInfo {
                match self {
                    $(Self::$Variant { .. } => const { &$plugin },)*
                }
            }

            /// The plugin's name in the file.
            pub fn plugin(&self) -> &'static str {
                self.info().name
            }
        }

        impl Declared for $Family {
            fn visit<'p>(&'p self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterRef<'p>)) {
                match self {
                    $(Self::$Variant $({ $($field),* })? $(($inside))? => {
                        $($(meet(const { &$info }, ParameterRef::$kind($field));)*)?
                        $($inside.visit(meet);)?
                    })*
                }
            }

            fn visit_mut(&mut self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterMut)) {
                match self {
                    $(Self::$Variant $({ $($field),* })? $(($inside))? => {
                        $($(meet(const { &$info }, ParameterMut::$kind($field));)*)?
                        $($as_mut($inside).visit_mut(meet);)?
                    })*
                }
            }
        }
    };
}

/// Declares the parameters of one plugin as a struct with defaults, in the syntax of `declare_plugins`.
macro_rules! declare_parameters {
    ($(#[$meta:meta])* pub struct $Plugin:ident {
        $($(#[$doc:meta])* $field:ident: $type:ty = $default:expr => $kind:ident($info:expr)),* $(,)?
    }) => {
        $(#[$meta])*
        #[allow(missing_docs, reason = "the declaration says what each plugin and parameter is")]
        pub struct $Plugin {
            $($(#[$doc])* pub $field: $type,)*
        }

        impl Default for $Plugin {
            fn default() -> Self {
                Self { $($field: $default),* }
            }
        }

        impl Declared for $Plugin {
            fn visit<'p>(&'p self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterRef<'p>)) {
                $(meet(const { &$info }, ParameterRef::$kind(&self.$field));)*
            }

            fn visit_mut(&mut self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterMut)) {
                $(meet(const { &$info }, ParameterMut::$kind(&mut self.$field));)*
            }
        }
    };
}

pub(in crate::scene) use {declare_parameters, declare_plugin_parameters, declare_plugin_type, declare_plugins};
