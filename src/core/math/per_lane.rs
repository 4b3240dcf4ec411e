//! The layout of types with one value per lane, and structs that are declared once for both a single value and lanes.

use glam::Vec3;

use super::lanes::{LANES, Lanes, Vec3Lanes, WordLanes, lanes_of};
use super::real::{Mask, Real, Vector};

/// A type with a form that holds a value per lane.
pub(crate) trait PerLane: Copy {
    /// The form with a value per lane.
    type Lanes;

    /// The same value in every lane.
    fn splat(self) -> Self::Lanes;

    /// The value of `lane`.
    fn gather_lane(lanes: &Self::Lanes, lane: usize) -> Self;

    /// Sets the value of `lane`.
    fn scatter_lane(self, lanes: &mut Self::Lanes, lane: usize);

    /// Copies the value of the lane `theirs` of `from` to `lane`.
    #[inline(always)]
    fn move_lane(lanes: &mut Self::Lanes, lane: usize, from: &Self::Lanes, theirs: usize) {
        Self::gather_lane(from, theirs).scatter_lane(lanes, lane);
    }
}

/// A bit per lane.
impl PerLane for bool {
    type Lanes = u32;

    #[inline(always)]
    fn splat(self) -> u32 {
        u32::from(self) * ((1 << LANES) - 1)
    }

    #[inline(always)]
    fn gather_lane(lanes: &u32, lane: usize) -> Self {
        lanes >> lane & 1 == 1
    }

    #[inline(always)]
    fn scatter_lane(self, lanes: &mut u32, lane: usize) {
        *lanes = *lanes & !(1 << lane) | u32::from(self) << lane;
    }
}

impl PerLane for f32 {
    type Lanes = Lanes;

    #[inline(always)]
    fn splat(self) -> Lanes {
        Lanes::splat(self)
    }

    #[inline(always)]
    fn gather_lane(lanes: &Lanes, lane: usize) -> Self {
        lanes.as_array()[lane]
    }

    #[inline(always)]
    fn scatter_lane(self, lanes: &mut Lanes, lane: usize) {
        lanes.as_mut_array()[lane] = self;
    }
}

impl PerLane for u32 {
    type Lanes = WordLanes;

    #[inline(always)]
    fn splat(self) -> WordLanes {
        WordLanes::splat(self)
    }

    #[inline(always)]
    fn gather_lane(lanes: &WordLanes, lane: usize) -> Self {
        lanes.as_array()[lane]
    }

    #[inline(always)]
    fn scatter_lane(self, lanes: &mut WordLanes, lane: usize) {
        lanes.as_mut_array()[lane] = self;
    }
}

impl PerLane for Vec3 {
    type Lanes = Vec3Lanes;

    #[inline(always)]
    fn splat(self) -> Vec3Lanes {
        Vec3Lanes::splat(self)
    }

    #[inline(always)]
    fn gather_lane(lanes: &Vec3Lanes, lane: usize) -> Self {
        lanes.get(lane)
    }

    #[inline(always)]
    fn scatter_lane(self, lanes: &mut Vec3Lanes, lane: usize) {
        lanes.set(lane, self);
    }
}

/// The form with a value per lane of a generic type, where that is the same type: see [`real_struct`].
pub(crate) trait LanesOf<One> {
    /// The same value in every lane.
    fn splat(one: One) -> Self;

    /// Sets the value of `lane`.
    fn set_lane(&mut self, lane: usize, one: One);
}

/// A type that can be repeated in every lane of its generic form, see [`real_struct`], for any form of numbers.
pub(crate) trait Same<R: Real> {
    /// The type in the form of numbers `R`.
    type Form;

    /// The same value in every lane.
    fn same(self) -> Self::Form;
}

/// Implements [`Same`] for the types of fields.
macro_rules! same {
    ($($One:ty => $Form:ty: |$one:ident| $same:expr;)*) => {
        $(
            impl<R: Real> Same<R> for $One {
                type Form = $Form;

                #[inline(always)]
                fn same(self) -> $Form {
                    let $one = self;
                    $same
                }
            }
        )*
    };
}

same! {
    f32 => R: |one| R::splat(one);
    Vec3 => R::Vec3: |one| R::Vec3::same(one);
}

/// A mask has all bits set in the lanes where it holds.
impl LanesOf<bool> for Lanes {
    #[inline(always)]
    fn splat(one: bool) -> Self {
        if one { Lanes::ALWAYS } else { Lanes::NEVER }
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, one: bool) {
        self.as_mut_array()[lane] = f32::from_bits(if one { u32::MAX } else { 0 });
    }
}

/// Implements [`LanesOf`] for types whose form is that of [`PerLane`].
macro_rules! lanes_of {
    ($($One:ty),*) => {
        $(
            impl LanesOf<$One> for <$One as PerLane>::Lanes {
                #[inline(always)]
                fn splat(one: $One) -> Self {
                    PerLane::splat(one)
                }

                #[inline(always)]
                fn set_lane(&mut self, lane: usize, one: $One) {
                    one.scatter_lane(self, lane);
                }
            }
        )*
    };
}

lanes_of!(f32, u32, Vec3);

/// The parameters of one kind of model or medium in the lanes that have it.
#[derive(Clone, Debug)]
pub(crate) struct Held<M> {
    /// A bit per lane.
    pub lanes: u32,
    /// The parameters in all lanes; lanes without the model have those of some lane with it.
    model: Option<M>,
}

impl<M> Default for Held<M> {
    fn default() -> Self {
        Self { lanes: 0, model: None }
    }
}

impl<M> Held<M> {
    #[inline(always)]
    pub fn set<One: Copy>(&mut self, lane: usize, one: One)
    where
        M: LanesOf<One>,
    {
        match &mut self.model {
            Some(model) if self.lanes != 0 => model.set_lane(lane, one),
            // Parameters of earlier surfaces would be evaluated in vain.
            model => *model = Some(M::splat(one)),
        }
        self.lanes |= 1 << lane;
    }

    /// The lanes that have the model, and their parameters; None if there are none.
    #[inline(always)]
    pub fn held(&self) -> Option<(Lanes, &M)> {
        match self.lanes {
            0 => None,
            lanes => Some((lanes_of(lanes), self.model.as_ref()?)),
        }
    }
}

/// Declares a struct that is generic over the form of its numbers, by default a single one: its fields are of the types
/// `R`, `R::Vec3`, `R::Mask` and `R::Word`, or other such structs. Its form of lanes is [`LanesOf`] the single form.
/// With `#[same]` in front it is [`Same`] as well, and its fields are `R`, `R::Vec3`, or other such structs.
///
/// ```ignore
/// real_struct! {
///     /// A diffuse surface.
///     pub struct Diffuse<R> {
///         /// The reflected fraction.
///         pub reflectance: R::Vec3,
///     }
/// }
/// ```
macro_rules! real_struct {
    (
        #[same]
        $(#[$about:meta])*
        $visible:vis struct $Name:ident<$R:ident> {
            $($(#[$about_field:meta])* $field_visible:vis $field:ident: $Field:ty,)*
        }
    ) => {
        $crate::math::real_struct! {
            $(#[$about])*
            $visible struct $Name<$R> {
                $($(#[$about_field])* $field_visible $field: $Field,)*
            }
        }

        impl<S: $crate::math::Real> $crate::math::Same<S> for $Name {
            type Form = $Name<S>;

            #[inline(always)]
            fn same(self) -> $Name<S> {
                $Name {
                    $($field: $crate::math::Same::<S>::same(self.$field),)*
                }
            }
        }
    };
    (
        $(#[$about:meta])*
        $visible:vis struct $Name:ident<$R:ident> {
            $($(#[$about_field:meta])* $field_visible:vis $field:ident: $Field:ty,)*
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $visible struct $Name<$R: $crate::math::Real = f32> {
            $($(#[$about_field])* $field_visible $field: $Field,)*
        }

        impl $crate::math::LanesOf<$Name> for $Name<$crate::math::lanes::Lanes> {
            #[inline(always)]
            fn splat(one: $Name) -> Self {
                Self {
                    $($field: $crate::math::LanesOf::splat(one.$field),)*
                }
            }

            #[inline(always)]
            fn set_lane(&mut self, lane: usize, one: $Name) {
                $($crate::math::LanesOf::set_lane(&mut self.$field, lane, one.$field);)*
            }
        }
    };
}

/// Declares a struct together with its form of lanes, whose fields are the lane forms of the same fields, and
/// implements [`PerLane`] between the two: a new field cannot be forgotten where lanes are read, written or moved.
///
/// ```ignore
/// per_lane! {
///     /// A particle.
///     pub struct Particle in ParticleLanes {
///         /// Metres.
///         pub position: Vec3,
///         pub is_alive: bool,
///     }
/// }
/// ```
macro_rules! per_lane {
    (
        $(#[$about:meta])*
        $visible:vis struct $One:ident in $Lanes:ident {
            $($(#[$about_field:meta])* $field_visible:vis $field:ident: $Field:ty,)*
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug)]
        $visible struct $One {
            $($(#[$about_field])* $field_visible $field: $Field,)*
        }

        #[doc = concat!("A [`", stringify!($One), "`] per lane.")]
        #[derive(Clone, Debug)]
        $visible struct $Lanes {
            $($field_visible $field: <$Field as $crate::math::PerLane>::Lanes,)*
        }

        impl $crate::math::PerLane for $One {
            type Lanes = $Lanes;

            #[inline(always)]
            fn splat(self) -> $Lanes {
                $Lanes {
                    $($field: <$Field as $crate::math::PerLane>::splat(self.$field),)*
                }
            }

            #[inline(always)]
            fn gather_lane(lanes: &$Lanes, lane: usize) -> Self {
                Self {
                    $($field: <$Field as $crate::math::PerLane>::gather_lane(&lanes.$field, lane),)*
                }
            }

            #[inline(always)]
            fn scatter_lane(self, lanes: &mut $Lanes, lane: usize) {
                $(<$Field as $crate::math::PerLane>::scatter_lane(self.$field, &mut lanes.$field, lane);)*
            }

            #[inline(always)]
            fn move_lane(lanes: &mut $Lanes, lane: usize, from: &$Lanes, theirs: usize) {
                $(<$Field as $crate::math::PerLane>::move_lane(&mut lanes.$field, lane, &from.$field, theirs);)*
            }
        }
    };
}
pub(crate) use per_lane;
pub(crate) use real_struct;

/// Implements [`PerLane`] for types that are rarely used: their lanes are an array, not vectors.
macro_rules! per_lane_array {
    ($($Type:ty),+ $(,)?) => {$(
        impl $crate::math::PerLane for $Type {
            type Lanes = [$Type; $crate::math::lanes::LANES];

            #[inline(always)]
            fn splat(self) -> Self::Lanes {
                [self; $crate::math::lanes::LANES]
            }

            #[inline(always)]
            fn gather_lane(lanes: &Self::Lanes, lane: usize) -> Self {
                lanes[lane]
            }

            #[inline(always)]
            fn scatter_lane(self, lanes: &mut Self::Lanes, lane: usize) {
                lanes[lane] = self;
            }
        }
    )+};
}
pub(crate) use per_lane_array;

#[cfg(test)]
mod tests {
    use super::*;

    per_lane! {
        struct Place in PlaceLanes {
            position: Vec3,
            height: f32,
            count: u32,
            is_open: bool,
        }
    }

    per_lane! {
        struct Visit in VisitLanes {
            place: Place,
            length: f32,
        }
    }

    fn visit(number: usize) -> Visit {
        Visit {
            place: Place {
                position: Vec3::new(1.0, 2.0, 3.0) * number as f32,
                height: 10.0 + number as f32,
                count: 20 + number as u32,
                is_open: number.is_multiple_of(3),
            },
            length: 30.0 + number as f32,
        }
    }

    #[test]
    fn every_lane_keeps_its_own_value() {
        let as_text = |visit: Visit| format!("{visit:?}");
        let mut lanes = visit(99).splat();
        let mut others = visit(0).splat();
        for lane in 0..LANES {
            assert_eq!(as_text(Visit::gather_lane(&lanes, lane)), as_text(visit(99)));
            visit(lane).scatter_lane(&mut lanes, lane);
        }
        for lane in 0..LANES {
            assert_eq!(as_text(Visit::gather_lane(&lanes, lane)), as_text(visit(lane)));
            Visit::move_lane(&mut others, lane, &lanes, LANES - 1 - lane);
        }
        for lane in 0..LANES {
            assert_eq!(
                as_text(Visit::gather_lane(&others, lane)),
                as_text(visit(LANES - 1 - lane))
            );
        }
    }
}
