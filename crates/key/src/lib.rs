//! Content keys: values become hashes by what they are made of, never by how they print.
//!
//! Numbers count by their bits, lists and texts have their length before them, and [`content_key!`] names every field of a
//! type, so that one that is added and forgotten does not compile.

mod feed;

/// The hash of a value's content. Values of one type have equal keys only if they are made of the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Key([u8; 32]);

impl Key {
    /// The hash as 64 hexadecimal digits.
    pub fn to_hex(self) -> String {
        blake3::Hash::from(self.0).to_hex().to_string()
    }
}

/// What a value's content is fed to.
#[derive(Clone, Debug, Default)]
pub struct KeyHasher(blake3::Hasher);

impl KeyHasher {
    /// Nothing fed yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Bytes as they are. Where their number may differ, feed it before them.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// The key of all that was fed.
    pub fn finish(&self) -> Key {
        Key(self.0.finalize().into())
    }
}

/// A value that can be told by its content from any other of its type.
///
/// ```
/// use trochoid_key::ContentKey;
///
/// assert_eq!((1.0, "a").key(), (1.0, String::from("a")).key());
/// assert_ne!(0.0.key(), (-0.0).key());
/// assert_ne!(["ab", "c"].key(), ["a", "bc"].key());
/// ```
pub trait ContentKey {
    /// Feeds all that the value is made of, so that no two values of the type feed the same bytes, nor one the beginning of
    /// what another feeds.
    fn feed(&self, hasher: &mut KeyHasher);

    /// The key of the value alone.
    fn key(&self) -> Key {
        let mut hasher = KeyHasher::new();
        self.feed(&mut hasher);
        hasher.finish()
    }
}

/// Implements [`ContentKey`] for a structure by its fields, or for an enumeration of plain names. All of them have to be
/// named.
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
/// A field that is left out does not compile:
///
/// ```compile_fail,E0027
/// struct Burst { height: f64, fade: Option<f64> }
/// trochoid_key::content_key!(Burst { height });
/// ```
///
/// Neither does a name:
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
