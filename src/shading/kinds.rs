//! The enums of scene files that have a variant for each kind of material, texture, light or primitive.

/// Declares such an enum. Each variant contains a type of its module, and has a name in scene files. All
/// types implement the trait after the name of the enum, which `model` returns.
macro_rules! kinds {
    (
        $(#[$attribute:meta])*
        pub enum $enum:ident: $vis:vis $model:ident {
            $($(#[$doc:meta])* $name:ident($type:ident) in $module:ident called $word:expr,)*
        }
    ) => {
        $(pub use self::$module::$type;)*

        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "snake_case")]
        #[non_exhaustive]
        pub enum $enum {
            $($(#[$doc])* $name($type),)*
        }

        $(impl From<$type> for $enum {
            fn from(kind: $type) -> Self {
                Self::$name(kind)
            }
        })*

        impl $enum {
            /// Returns the name of the kind in scene files.
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => $word,)*
                }
            }

            $vis fn model(&self) -> &dyn $model {
                match self {
                    $(Self::$name(kind) => kind,)*
                }
            }
        }
    };
}
pub(crate) use kinds;
