//! Content keys of numbers, texts, paths, times and containers.

use crate::{ContentKey, Key, KeyHasher};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

macro_rules! numbers {
    ($($type:ty)+) => {
        $(impl ContentKey for $type {
            fn feed(&self, hasher: &mut KeyHasher) {
                hasher.bytes(&self.to_le_bytes());
            }
        })+
    };
}

numbers!(u8 u16 u32 u64 u128 i32 i64 f32 f64);

impl ContentKey for usize {
    fn feed(&self, hasher: &mut KeyHasher) {
        (*self as u64).feed(hasher);
    }
}

impl ContentKey for bool {
    fn feed(&self, hasher: &mut KeyHasher) {
        u8::from(*self).feed(hasher);
    }
}

impl ContentKey for Key {
    fn feed(&self, hasher: &mut KeyHasher) {
        hasher.bytes(&self.0);
    }
}

impl ContentKey for str {
    fn feed(&self, hasher: &mut KeyHasher) {
        self.len().feed(hasher);
        hasher.bytes(self.as_bytes());
    }
}

impl ContentKey for String {
    fn feed(&self, hasher: &mut KeyHasher) {
        self.as_str().feed(hasher);
    }
}

impl ContentKey for Path {
    fn feed(&self, hasher: &mut KeyHasher) {
        let bytes = self.as_os_str().as_encoded_bytes();
        bytes.len().feed(hasher);
        hasher.bytes(bytes);
    }
}

impl ContentKey for PathBuf {
    fn feed(&self, hasher: &mut KeyHasher) {
        self.as_path().feed(hasher);
    }
}

impl ContentKey for SystemTime {
    fn feed(&self, hasher: &mut KeyHasher) {
        let nanoseconds = |apart: std::time::Duration| apart.as_nanos();
        match self.duration_since(UNIX_EPOCH) {
            Ok(after) => (true, nanoseconds(after)).feed(hasher),
            Err(before) => (false, nanoseconds(before.duration())).feed(hasher),
        }
    }
}

impl<T: ContentKey + ?Sized> ContentKey for &T {
    fn feed(&self, hasher: &mut KeyHasher) {
        (**self).feed(hasher);
    }
}

impl<T: ContentKey + ?Sized> ContentKey for Arc<T> {
    fn feed(&self, hasher: &mut KeyHasher) {
        (**self).feed(hasher);
    }
}

impl<T: ContentKey> ContentKey for Option<T> {
    fn feed(&self, hasher: &mut KeyHasher) {
        self.is_some().feed(hasher);
        if let Some(value) = self {
            value.feed(hasher);
        }
    }
}

impl<T: ContentKey> ContentKey for [T] {
    fn feed(&self, hasher: &mut KeyHasher) {
        self.len().feed(hasher);
        self.iter().for_each(|value| value.feed(hasher));
    }
}

impl<T: ContentKey, const N: usize> ContentKey for [T; N] {
    fn feed(&self, hasher: &mut KeyHasher) {
        self.as_slice().feed(hasher);
    }
}

impl<T: ContentKey> ContentKey for Vec<T> {
    fn feed(&self, hasher: &mut KeyHasher) {
        self.as_slice().feed(hasher);
    }
}

macro_rules! tuples {
    ($(($($name:ident)+))+) => {
        $(impl<$($name: ContentKey),+> ContentKey for ($($name,)+) {
            fn feed(&self, hasher: &mut KeyHasher) {
                #[allow(non_snake_case, reason = "one name for a type and its value")]
                let ($($name,)+) = self;
                $($name.feed(hasher);)+
            }
        })+
    };
}

tuples!((A B)(A B C)(A B C D)(A B C D E));

#[cfg(test)]
mod tests {
    use crate::{ContentKey, Key, KeyHasher, content_key};
    use std::collections::HashSet;
    use std::path::Path;
    use std::time::{Duration, UNIX_EPOCH};

    /// A number that prints only three decimals.
    struct Silent(f64);

    impl std::fmt::Debug for Silent {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            write!(f, "{:.3}", self.0)
        }
    }

    impl ContentKey for Silent {
        fn feed(&self, hasher: &mut KeyHasher) {
            self.0.feed(hasher);
        }
    }

    fn all_differ(keys: &[Key]) -> bool {
        keys.iter().collect::<HashSet<_>>().len() == keys.len()
    }

    #[test]
    fn what_prints_alike_has_keys_of_its_own() {
        let (a, b) = (Silent(1.0 / 3.0), Silent(0.333));
        assert_eq!(format!("{a:?}"), format!("{b:?}"));
        assert_ne!(a.key(), b.key());
        let quiet = f64::from_bits(f64::NAN.to_bits() ^ 1);
        assert_eq!(format!("{quiet}"), format!("{}", f64::NAN));
        assert_ne!(quiet.key(), f64::NAN.key());
    }

    #[test]
    fn lengths_part_what_would_run_together() {
        let texts = [("ab", "c"), ("a", "bc"), ("", "abc"), ("abc", "")].map(|pair| pair.key());
        assert!(all_differ(&texts));
        let lists: [Vec<Vec<u8>>; 4] = [vec![vec![1], vec![]], vec![vec![], vec![1]], vec![vec![1]], vec![]];
        assert!(all_differ(&lists.map(|list| list.key())));
        assert!(all_differ(&[None, Some(None), Some(Some(0_u8))].map(|value| value.key())));
        assert!(all_differ(&[0.0, -0.0, f64::INFINITY, f64::MIN_POSITIVE].map(|value| value.key())));
    }

    #[test]
    fn times_before_and_after_the_epoch_differ() {
        let second = Duration::from_secs(1);
        let times = [UNIX_EPOCH - second, UNIX_EPOCH, UNIX_EPOCH + second, UNIX_EPOCH + Duration::from_nanos(1)];
        assert!(all_differ(&times.map(|time| time.key())));
    }

    #[test]
    fn keys_stay_the_same_from_version_to_version() {
        let value = (7_u32, "sea", [0.5_f64, -1.0], Some(true), Path::new("a/b.exr"));
        let mut bytes = Vec::new();
        bytes.extend(7_u32.to_le_bytes());
        bytes.extend(3_u64.to_le_bytes());
        bytes.extend(b"sea");
        bytes.extend(2_u64.to_le_bytes());
        bytes.extend(0.5_f64.to_le_bytes());
        bytes.extend((-1.0_f64).to_le_bytes());
        bytes.extend([1, 1]);
        bytes.extend(7_u64.to_le_bytes());
        bytes.extend(b"a/b.exr");
        assert_eq!(value.key().to_hex(), blake3::hash(&bytes).to_hex().to_string());
    }

    #[derive(Clone)]
    struct Knobs {
        height: f64,
        count: u32,
        name: String,
        edge: Edge,
    }

    #[derive(Clone, Copy)]
    enum Edge {
        Open,
        Closed,
    }

    content_key!(Knobs { height, count, name, edge });
    content_key!(
        enum Edge {
            Open,
            Closed,
        }
    );

    #[test]
    fn every_field_counts() {
        let knobs = Knobs { height: 1.0, count: 2, name: "a".into(), edge: Edge::Open };
        let others = [
            Knobs { height: 1.0_f64.next_up(), ..knobs.clone() },
            Knobs { count: 3, ..knobs.clone() },
            Knobs { name: "b".into(), ..knobs.clone() },
            Knobs { edge: Edge::Closed, ..knobs.clone() },
        ];
        let mut keys: Vec<Key> = others.iter().map(ContentKey::key).collect();
        keys.push(knobs.key());
        assert!(all_differ(&keys));
        assert_eq!(knobs.key(), knobs.clone().key());
    }
}
