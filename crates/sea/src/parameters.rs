//! Names of model parameters, for error messages.

/// Defines an enum of parameters, each printed by its name.
macro_rules! figures {
    ($(#[$doc:meta])* $name:ident { $($figure:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name {
            $(#[doc = concat!("Printed as: ", $text, ".")] $figure,)*
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self {
                    $(Self::$figure => $text,)*
                })
            }
        }
    };
}
