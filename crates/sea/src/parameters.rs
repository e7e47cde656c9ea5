//! Names of model parameters, for error messages.

/// Defines an enum of parameters, each printed by its name.
macro_rules! parameters {
    ($(#[$doc:meta])* $name:ident { $($parameter:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name {
            $(#[doc = concat!("Printed as: ", $text, ".")] $parameter,)*
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self {
                    $(Self::$parameter => $text,)*
                })
            }
        }
    };
}
