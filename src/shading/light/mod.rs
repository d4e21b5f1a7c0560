//! Lights that paths sample directly. Each kind has a file with its table and its sampling.
//!
//! The list in `lights!` generates the kinds, the tables, and the enum of scene files.

mod alias;
mod builder;
mod chosen;
mod distant;
mod environment;
mod file;
mod lights;
mod point;
mod quad;
mod sample;
mod shares;
mod sphere;
mod spherical_rectangle;
mod spherical_triangle;
mod spot;
mod tree;
mod triangle;

use std::fmt::Debug;

use glam::DVec3;

pub(crate) use self::builder::LightsBuilder;
pub(crate) use self::chosen::Chosen;
pub(crate) use self::environment::Environment;
pub use self::environment::{EnvironmentMap, Mapping};
use self::file::FreeLightModel;
pub(crate) use self::lights::Lights;
pub(crate) use self::sample::LightSample;
pub use self::spot::Falloff;
use super::kinds::kinds;
use crate::geometry::{Primitive, Ray};
use crate::math::Real;

/// A kind of light. The implementing type is an entry in the table of that kind.
///
/// Samples are uniform in the light's solid angle whenever that can be computed.
pub(crate) trait LightModel: Debug + Sized {
    /// Whether only light samples find lights of this kind: no path can hit them.
    const UNSEEN: bool = false;

    /// Returns the primitive as a light of this kind. Returns `None` if the primitive has another
    /// shape. Kinds of lights that are not primitives always return `None`.
    fn of(_primitive: Primitive) -> Option<PrimitiveLight<Self>> {
        None
    }

    /// Samples directions from `from` to the entries at `index`.
    fn sample<R: Real>(
        table: &[Self],
        index: R::Index,
        from: R::Vec3,
        time: R,
        uv: (R, R),
    ) -> LightSample<R>;

    /// Returns the density with which [`LightModel::sample`] draws `ray.direction` from
    /// `ray.origin`. The rays hit the entries at distance `t`.
    ///
    /// The default is for lights that no path can hit.
    #[inline(always)]
    fn pdf<R: Real>(_table: &[Self], _index: R::Index, _ray: &Ray<R>, _t: R) -> R {
        R::ZERO
    }
}

/// A primitive as a light.
pub(crate) struct PrimitiveLight<L> {
    light: L,
    area: f64,
    /// Unit normal of a flat light.
    normal: Option<DVec3>,
}

/// Smallest solid angle at which flat lights are sampled by solid angle. Below it, the sum of the
/// corner angles has lost too many digits.
const MIN_SOLID_ANGLE: f32 = 1e-3;
/// A flat light is sampled by solid angle only if the sine of the angle between its plane and the
/// direction to its farthest corner is above this value. Below it, the mapping from angles to
/// points has lost too many digits.
const MIN_SINE: f32 = 2.5e-3;

/// A kind of light in the list, which has a table in [`LightTables`].
trait Listed: LightModel {
    const KIND: LightKind;

    /// Returns the table of this kind.
    fn table(tables: &mut LightTables) -> &mut Vec<Self>;
}

/// Code that runs once for each table of lights, and passes a value from one to the next.
trait TableFold {
    type Value;

    /// Returns the value for the next table, after the table of the kind `L`.
    fn step<L: Listed>(&self, table: &[L], value: Self::Value) -> Self::Value;
}

macro_rules! lights {
    ($($(#[$doc:meta])* $name:ident in $module:ident $(described by $file:ident)?,)*) => {
        kinds! {
            /// A light that is not a primitive.
            pub enum LightFile: FreeLightModel {
                $($(#[$doc])* $($file($file) in $module called stringify!($module),)?)*
            }
        }

        #[derive(Clone, Copy)]
        enum LightKind {
            $($name,)*
        }

        /// The lights of a scene, one table per kind.
        #[derive(Debug, Default)]
        struct LightTables {
            $($module: Vec<$module::$name>,)*
        }

        $(impl Listed for $module::$name {
            const KIND: LightKind = LightKind::$name;

            fn table(tables: &mut LightTables) -> &mut Vec<Self> {
                &mut tables.$module
            }
        })*

        impl LightTables {
            /// Passes `value` through all tables.
            #[inline(always)]
            fn fold<F: TableFold>(&self, fold: &F, value: F::Value) -> F::Value {
                $(let value = fold.step(&self.$module[..], value);)*
                value
            }

            /// Adds a primitive.
            fn push_primitive(&mut self, primitive: Primitive) -> PrimitiveEntry {
                None$(.or_else(|| self.try_primitive::<$module::$name>(primitive)))*
                    .expect("every primitive can be a light")
            }
        }
    };
}

lights! {
    SphereLight in sphere,
    QuadLight in quad,
    TriangleLight in triangle,
    /// A point.
    PointLight in point described by Point,
    /// A point that shines into a cone.
    SpotLight in spot described by Spot,
    /// Parallel light, such as that of the sun.
    DistantLight in distant described by Distant,
    Environment in environment,
}

/// The flags of a light, and its index in the table of its kind.
type Entry = (u32, u32);

/// The entry of a primitive, its area, and its unit normal if it is flat.
type PrimitiveEntry = (Entry, f64, Option<DVec3>);

impl LightTables {
    /// Adds a light.
    fn push<L: Listed>(&mut self, light: L) -> Entry {
        let table = L::table(self);
        table.push(light);
        let unseen = if L::UNSEEN { lights::UNSEEN } else { 0 };
        ((L::KIND as u32) << lights::KIND_SHIFT | unseen, table.len() as u32 - 1)
    }

    /// Adds the primitive as a light of the kind `L`. Returns `None` if it has another shape.
    fn try_primitive<L: Listed>(&mut self, primitive: Primitive) -> Option<PrimitiveEntry> {
        let PrimitiveLight { light, area, normal } = L::of(primitive)?;
        Some((self.push(light), area, normal))
    }
}
