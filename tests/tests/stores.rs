//! A simulation goes on from what another process kept, and has the same bits.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex};
use trochoid::{Buffers, Cache, Key, Plan, Settings, Silent, Store, StoredEntry, parse};

/// Store in memory, which is always used.
#[derive(Debug, Default)]
struct Eager(Mutex<HashMap<(Key, u64), Vec<u8>>>, Mutex<Vec<u64>>);

impl Store for Eager {
    fn find(&self, series: Key, least: u64, most: u64) -> Option<StoredEntry> {
        let kept = self.0.lock().unwrap();
        let here = kept.iter().filter(|((key, number), _)| *key == series && (least + 1..=most).contains(number));
        let (&(_, number), data) = here.max_by_key(|((_, number), _)| *number)?;
        Some(StoredEntry { number, bytes: data.len() as u64, seconds: 1e6 })
    }

    fn read(&self, series: Key, entry: &StoredEntry) -> Option<Vec<u8>> {
        self.1.lock().unwrap().push(entry.number);
        self.0.lock().unwrap().get(&(series, entry.number)).cloned()
    }

    fn keep(&self, series: Key, number: u64, _seconds: f64, data: &[u8]) {
        self.0.lock().unwrap().insert((series, number), data.to_vec());
    }

    fn reading_pays(&self, _bytes: u64, _seconds: f64) -> bool {
        true
    }

    fn keeping_pays(&self, _bytes: u64, _seconds: f64) -> bool {
        true
    }
}

/// Heights, rift and drift lines of a toon sea.
#[test]
fn a_sea_goes_on_from_what_another_process_kept() {
    let document = r##"{ "trochoid": 1, "format": { "width": 64, "height": 36 }, "frames": { "first": 1, "last": 90 },
      "nodes": {
        "camera": { "type": "Camera", "position": [4, 3, 12], "target": [4, 0, 4] },
        "waves": { "type": "ToonSea", "columns": 40, "rows": 40, "spacing": 0.2, "preroll": 30,
                   "bursts": [{ "path": [0, 0, 2, 4, 4, 4, 8, 6], "duration": 3, "offset": 1, "height": 1 }] },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["waves"] },
        "rift": { "type": "Rift", "view": "view" },
        "height": { "type": "Height", "view": "view" },
        "high": { "type": "Clamp", "field": "height", "min": -0.2, "max": 0.8 },
        "lines": { "type": "DriftLines", "view": "view" },
        "sea": { "type": "Mix", "a": "#102040", "b": "#ffffff", "weight": "high" },
        "far": { "type": "Clamp", "field": "rift", "min": 0, "max": 1 },
        "foam": { "type": "Mix", "a": "sea", "b": "#40ff80", "weight": "far" },
        "print": { "type": "Mix", "a": "foam", "b": "#ff3010", "weight": "lines" } },
      "outputs": { "print": { "color": "print" } } }"##;
    let graph = parse("sea", document, Path::new("."), &[]).unwrap().graph;
    let picture = |frame: i64, cache: &mut Cache| {
        let plan = Plan::new(&graph, &["print"], frame, &[], &Settings::default()).unwrap();
        plan.evaluate(&Buffers::new(), cache, &Silent).unwrap().pictures.remove(0).planes
    };
    let store = Arc::new(Eager::default());
    let with_store = || Cache::new().with_store(store.clone());
    let alone = |frame: i64| picture(frame, &mut Cache::new());
    let first = picture(40, &mut with_store());
    assert!(first == alone(40) && store.1.lock().unwrap().is_empty());
    assert_eq!(store.0.lock().unwrap().len(), 3, "heights, rift and drift");
    // Another process, at the same frame, a later one, an earlier one; and one after the other.
    for frame in [40, 70, 20] {
        store.1.lock().unwrap().clear();
        assert!(picture(frame, &mut with_store()) == alone(frame), "frame {frame}");
        let read = store.1.lock().unwrap().clone();
        assert_eq!(read.len(), if frame == 20 { 0 } else { 3 }, "frame {frame}: {read:?}");
    }
    let mut cache = with_store();
    for frame in [60, 65, 30, 90, 1] {
        assert!(picture(frame, &mut cache) == alone(frame), "frame {frame} in a run");
    }
    // States of other lengths are not used.
    store.0.lock().unwrap().values_mut().for_each(|data| data.truncate(100));
    assert!(picture(70, &mut with_store()) == alone(70));
}
