//! Names of the values of an enum, as the command line and records have them.

/// Gives an enum the constant `ALL` and the method `name`.
macro_rules! names {
    ($access:vis $type:ident: $($value:ident = $name:literal),* $(,)?) => {
        impl $type {
            /// All values, in their order.
            $access const ALL: [Self; [$($name),*].len()] = [$(Self::$value),*];

            /// The name on the command line and in records.
            $access fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name,)*
                }
            }
        }
    };
}
