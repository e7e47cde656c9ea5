//! Values that take too long for the thread that draws.

use egui::Context;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

/// Time after which a value that is not there yet is called late.
const PATIENCE: Duration = Duration::from_millis(300);

/// The value for the newest key. A thread makes it; until it is there, the one before stays.
pub(super) struct Live<K, T> {
    known: Option<(K, T)>,
    made: Option<(K, Receiver<T>, Instant)>,
    /// The key whose thread panicked: its value is not asked for again.
    failed: Option<K>,
}

impl<K, T> Default for Live<K, T> {
    fn default() -> Self {
        Self { known: None, made: None, failed: None }
    }
}

impl<K: PartialEq, T: Send + 'static> Live<K, T> {
    /// Returns the value that was made last, and whether it is that of the key. If it is not, a thread makes it, as soon
    /// as none is at work.
    pub(super) fn get(
        &mut self,
        key: K,
        context: &Context,
        make: impl FnOnce() -> T + Send + 'static,
    ) -> (Option<&T>, bool) {
        match self.made.as_ref().map(|(_, inbox, _)| inbox.try_recv()) {
            Some(Ok(value)) => self.known = self.made.take().map(|(key, ..)| (key, value)),
            Some(Err(TryRecvError::Disconnected)) => self.failed = self.made.take().map(|(key, ..)| key),
            Some(Err(TryRecvError::Empty)) | None => {}
        }
        let is_known = self.known.as_ref().is_some_and(|(known, _)| *known == key);
        if !is_known && self.made.is_none() && self.failed.as_ref() != Some(&key) {
            let (sender, inbox) = channel();
            context.request_repaint_after(PATIENCE);
            let context = context.clone();
            std::thread::spawn(move || {
                // The panel may be gone by then.
                let _ = sender.send(make());
                context.request_repaint();
            });
            self.made = Some((key, inbox, Instant::now()));
        }
        (self.known.as_ref().map(|(_, value)| value), is_known)
    }

    /// Returns whether a value is being made, and takes long.
    pub(super) fn is_late(&self) -> bool {
        self.made.as_ref().is_some_and(|(.., since)| since.elapsed() >= PATIENCE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::Sender;
    use std::time::{Duration, Instant};

    /// Asks for a key until its value is there.
    fn awaited(live: &mut Live<u32, u32>, key: u32) -> u32 {
        let started = Instant::now();
        loop {
            if let (Some(value), true) = live.get(key, &Context::default(), move || 10 * key) {
                return *value;
            }
            assert!(started.elapsed() < Duration::from_secs(60), "waited in vain for {key}");
            std::thread::yield_now();
        }
    }

    #[test]
    fn the_value_before_stays_until_the_newest_is_there() {
        let (context, mut live) = (Context::default(), Live::default());
        assert_eq!(awaited(&mut live, 1), 10);
        let (go, wait): (Sender<()>, _) = channel();
        let slow = move || {
            let _ = wait.recv();
            20
        };
        assert_eq!(live.get(2, &context, slow), (Some(&10), false));
        // Only one thread is at work.
        assert_eq!(live.get(3, &context, || unreachable!()), (Some(&10), false));
        go.send(()).unwrap();
        assert_eq!(awaited(&mut live, 3), 30);
    }
}
