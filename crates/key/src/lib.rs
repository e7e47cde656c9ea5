//! Content keys: hashes of values, made from their content rather than from their printed form.
//!
//! Numbers are hashed by their bits, lists and texts after their length, and [`content_key!`] must name every field
//! of a type: code that forgets a new field does not compile.

mod feed;

/// Hash of a value's content. Values of one type have equal keys only if they consist of the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Key([u8; 32]);

impl Key {
    /// Returns the hash as 64 hexadecimal digits.
    pub fn to_hex(self) -> String {
        blake3::Hash::from(self.0).to_hex().to_string()
    }
}

/// Hasher to which the content of values is fed.
#[derive(Clone, Debug, Default)]
pub struct KeyHasher(blake3::Hasher);

impl KeyHasher {
    /// Makes a hasher without any content.
    pub fn new() -> Self {
        Self::default()
    }

    /// Feeds bytes without their number. If it can vary, feed it before them.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// Returns the key of everything fed so far.
    pub fn finish(&self) -> Key {
        Key(self.0.finalize().into())
    }
}

/// A value whose content distinguishes it from all other values of its type.
///
/// ```
/// use trochoid_key::ContentKey;
///
/// assert_eq!((1.0, "a").key(), (1.0, String::from("a")).key());
/// assert_ne!(0.0.key(), (-0.0).key());
/// assert_ne!(["ab", "c"].key(), ["a", "bc"].key());
/// ```
pub trait ContentKey {
    /// Feeds the whole content of the value: the bytes of two different values must differ, and must not be the
    /// beginning of each other.
    fn feed(&self, hasher: &mut KeyHasher);

    /// Returns the key of the value alone.
    fn key(&self) -> Key {
        let mut hasher = KeyHasher::new();
        self.feed(&mut hasher);
        hasher.finish()
    }
}

/// Implements [`ContentKey`] for a struct by its fields, or for an enum without data by its variants. All of them
/// must be named.
///
/// ```
/// use trochoid_key::{ContentKey, content_key};
///
/// struct Burst { height: f64, fade: Option<f64> }
/// enum Edge { Open, Closed }
/// content_key!(Burst { height, fade });
/// content_key!(enum Edge { Open, Closed });
///
/// assert_ne!(Burst { height: 1.0, fade: None }.key(), Burst { height: 1.0, fade: Some(0.0) }.key());
/// assert_ne!(Edge::Open.key(), Edge::Closed.key());
/// ```
///
/// Without one of the fields it does not compile:
///
/// ```compile_fail,E0027
/// struct Burst { height: f64, fade: Option<f64> }
/// trochoid_key::content_key!(Burst { height });
/// ```
///
/// Nor without one of the variants:
///
/// ```compile_fail,E0004
/// enum Edge { Open, Closed }
/// trochoid_key::content_key!(enum Edge { Open });
/// ```
#[macro_export]
macro_rules! content_key {
    (enum $type:ty { $($name:ident),+ $(,)? }) => {
        impl $crate::ContentKey for $type {
            fn feed(&self, hasher: &mut $crate::KeyHasher) {
                match self {
                    $(Self::$name => $crate::ContentKey::feed(stringify!($name), hasher),)+
                }
            }
        }
    };
    ($type:ty { $($field:ident),+ $(,)? }) => {
        impl $crate::ContentKey for $type {
            fn feed(&self, hasher: &mut $crate::KeyHasher) {
                let Self { $($field),+ } = self;
                $($crate::ContentKey::feed($field, hasher);)+
            }
        }
    };
}
