//! Claims: what one of several processes works on, told to the others by a file.

use crate::Error;
use crate::partial::{Registered, stands_at};
use std::collections::HashMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Action, for messages.
const CLAIM: &str = "claim the file";
/// Time between two signs of life of a claim on a file system without locks.
const BEAT: Duration = Duration::from_secs(5);
/// Largest number of names that are tried for a claim.
const ATTEMPTS: u32 = 1000;

/// Claims of one process among others, on the same machine or on others that share a folder.
///
/// A claim of `a.exr` is the file `.trochoid-a.exr.claim` beside it, which its holder locks: the system takes the lock
/// from a process that ends in any way, and the next one takes the claim over at once. On file systems without locks, a
/// claim is a file that only one process can make. Its holder writes a sign of life into it every five seconds; one
/// whose file stays the same for `patience` is gone, and its claim is taken over by a file with the next number. Clocks
/// of machines are not compared.
///
/// ```
/// use std::time::Duration;
/// use trochoid_io::Claims;
///
/// let folder = tempfile::tempdir()?;
/// let file = folder.path().join("a.exr");
/// let (ours, theirs) = (Claims::new(Duration::from_secs(60)), Claims::new(Duration::from_secs(60)));
/// let claim = ours.claim(&file)?.expect("nobody has it");
/// assert!(theirs.claim(&file)?.is_none());
/// drop(claim);
/// assert!(theirs.claim(&file)?.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Claims {
    patience: Duration,
    /// Claims of others on file systems without locks: what their files had, and since when.
    watched: Mutex<HashMap<PathBuf, (Vec<u8>, Instant)>>,
}

/// A claim, which ends when it is dropped.
#[derive(Debug)]
pub struct Claim {
    /// Files of the claim, oldest first, which are removed.
    files: Vec<PathBuf>,
    held: Held,
    registered: Option<Registered>,
}

#[derive(Debug)]
enum Held {
    /// The file is locked.
    Lock(#[expect(dead_code, reason = "it is held")] File),
    /// A thread gives signs of life until the sender is dropped.
    Beats(Option<(Sender<()>, JoinHandle<()>)>),
}

impl Claims {
    /// Creates claims. A holder on a file system without locks is gone if it gives no sign of life for `patience`, which
    /// should be several times five seconds.
    pub fn new(patience: Duration) -> Self {
        Self { patience, watched: Mutex::default() }
    }

    /// Claims a file, which need not exist, in a folder that does; `None` if another process has claimed it.
    ///
    /// What the claim is for may have been done before it was made.
    ///
    /// # Errors
    /// The folder accepts no files.
    pub fn claim(&self, file: &Path) -> Result<Option<Claim>, Error> {
        let path = name(file, 0);
        for _ in 0..ATTEMPTS {
            let open = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
            let open = open.map_err(Error::io(file, CLAIM))?;
            match open.try_lock() {
                // The last holder may have removed the file.
                Ok(()) if stands_at(&open, &path) => {
                    // Some file systems grant a process locks that it holds already.
                    let Some(registered) = Registered::new(&path) else { return Ok(None) };
                    return Ok(Some(Claim { files: vec![path], held: Held::Lock(open), registered: Some(registered) }));
                }
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(_)) => {
                    drop(open);
                    return self.claim_without_locks(file);
                }
            }
        }
        Ok(None)
    }

    /// Claims a file by making another that nobody has made.
    fn claim_without_locks(&self, file: &Path) -> Result<Option<Claim>, Error> {
        // Number 0 is the file that could not be locked.
        for number in 1..ATTEMPTS {
            let path = name(file, number);
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(made) => {
                    let files = (0..=number).map(|number| name(file, number)).collect();
                    let registered = Registered::new(&path);
                    return Ok(Some(Claim { files, held: Held::Beats(beats(made)), registered }));
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                    if !self.is_gone(&path) {
                        return Ok(None);
                    }
                }
                Err(error) => return Err(Error::io(file, CLAIM)(error)),
            }
        }
        Ok(None)
    }

    /// Returns whether the holder of a claim has given no sign of life for too long.
    fn is_gone(&self, path: &Path) -> bool {
        let mut found = Vec::new();
        let read = crate::open_file(path).is_ok_and(|file| file.reader().take(64).read_to_end(&mut found).is_ok());
        if !read {
            // It may have just ended.
            return false;
        }
        let mut watched = self.watched.lock().unwrap_or_else(PoisonError::into_inner);
        let (known, since) = watched.entry(path.into()).or_insert_with(|| (found.clone(), Instant::now()));
        if *known != found {
            (*known, *since) = (found, Instant::now());
        }
        since.elapsed() > self.patience
    }
}

/// Returns the name of a claim's file.
fn name(file: &Path, number: u32) -> PathBuf {
    let own = file.file_name().unwrap_or_default().to_string_lossy();
    let number = if number == 0 { String::new() } else { format!(".{number}") };
    file.with_file_name(format!(".trochoid-{own}.claim{number}"))
}

/// Starts signs of life: numbers that are counted up.
fn beats(mut file: File) -> Option<(Sender<()>, JoinHandle<()>)> {
    let (stop, stopped) = channel();
    // Files of two holders differ from the start.
    let start = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0, |time| time.as_nanos());
    let mut count = start + u128::from(std::process::id());
    let thread = std::thread::Builder::new().name("claim".into()).spawn(move || {
        loop {
            // A claim that cannot be written is taken over by another process, which does no harm.
            let _ = file.seek(SeekFrom::Start(0)).and_then(|_| file.write_all(format!("{count:040}\n").as_bytes()));
            let _ = file.flush();
            count += 1;
            if stopped.recv_timeout(BEAT) != Err(RecvTimeoutError::Timeout) {
                return;
            }
        }
    });
    thread.ok().map(|thread| (stop, thread))
}

impl Drop for Claim {
    fn drop(&mut self) {
        if let Held::Beats(beats) = &mut self.held
            && let Some((stop, thread)) = beats.take()
        {
            drop(stop);
            let _ = thread.join();
        }
        self.registered.take();
        // They are removed before the lock is given up, so that nobody holds a file without a name.
        for file in &self.files {
            let _ = fs::remove_file(file);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_secs(3600);

    #[test]
    fn one_of_many_threads_has_a_claim_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.exr");
        let holders = std::sync::atomic::AtomicUsize::new(0);
        let had = std::sync::atomic::AtomicUsize::new(0);
        for locks in [true, false] {
            std::thread::scope(|scope| {
                for _ in 0..8 {
                    scope.spawn(|| {
                        let claims = Claims::new(LONG);
                        let mut own = 0;
                        // Whatever the scheduler does, each has it sometimes.
                        for _ in 0..1_000_000 {
                            if own == 4 {
                                break;
                            }
                            let claim = if locks { claims.claim(&file) } else { claims.claim_without_locks(&file) };
                            if let Some(claim) = claim.unwrap() {
                                assert_eq!(holders.fetch_add(1, std::sync::atomic::Ordering::SeqCst), 0);
                                had.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
                                std::thread::yield_now();
                                holders.fetch_sub(1, std::sync::atomic::Ordering::SeqCst);
                                own += 1;
                                drop(claim);
                            }
                            std::thread::yield_now();
                        }
                    });
                }
            });
            assert_eq!(had.swap(0, std::sync::atomic::Ordering::SeqCst), 8 * 4);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left");
    }

    #[test]
    fn what_the_dead_have_claimed_is_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.exr");
        let claims = Claims::new(Duration::from_millis(20));
        // A file without a lock is one of a process that has ended.
        fs::write(name(&file, 0), "").unwrap();
        drop(claims.claim(&file).unwrap().unwrap());
        // Without locks, it is one that gives no sign of life.
        fs::write(name(&file, 1), "1").unwrap();
        assert!(claims.claim_without_locks(&file).unwrap().is_none(), "it is watched from now on");
        std::thread::sleep(Duration::from_millis(30));
        fs::write(name(&file, 1), "2").unwrap();
        assert!(claims.claim_without_locks(&file).unwrap().is_none(), "it lives");
        std::thread::sleep(Duration::from_millis(30));
        let claim = claims.claim_without_locks(&file).unwrap().unwrap();
        assert!(Claims::new(LONG).claim_without_locks(&file).unwrap().is_none(), "it is taken");
        drop(claim);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left");
    }

    #[test]
    fn a_holder_gives_signs_of_life() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.exr");
        let claim = Claims::new(LONG).claim_without_locks(&file).unwrap().unwrap();
        let read = || fs::read(name(&file, 1)).unwrap();
        let first = read();
        let started = Instant::now();
        while read() == first {
            assert!(started.elapsed() < 12 * BEAT, "no sign of life");
            std::thread::sleep(Duration::from_millis(50));
        }
        drop(claim);
    }

    #[test]
    fn a_folder_that_is_not_there_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let error = Claims::new(LONG).claim(&folder.path().join("none/a.exr")).unwrap_err();
        assert!(error.to_string().contains("none/a.exr: cannot claim the file"), "{error}");
    }
}
