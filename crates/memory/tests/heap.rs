//! Tests of the memory of a whole program. The bound is global, so a single test makes all checks one after another. It has
//! no harness: the first thread of a program gets memory in another way than others.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::process::Command;
use trochoid_memory::{Buffer, Exhausted, Heap, fallible};

#[global_allocator]
static HEAP: Heap = Heap;

const MB: usize = 1 << 20;

/// Environment variable that names the task of a child process of this test.
const TASK: &str = "TROCHOID_TEST_HEAP";

fn end(exhausted: Exhausted) -> ! {
    println!("asked {} bound {:?}", exhausted.asked, exhausted.bound);
    std::process::exit(7)
}

fn end_without_memory(_: Exhausted) -> ! {
    // The bound no longer applies to the thread that ends the program, but the limit of the system does.
    let all = vec![1_u8; isize::MAX as usize - 4096];
    std::process::exit(i32::from(all[0]) + 7)
}

/// Runs a task in a separate process; returns its output and its exit code.
fn child(task: &str) -> (String, Option<i32>) {
    let this = std::env::current_exe().unwrap();
    let output = Command::new(this).env(TASK, task).output();
    let output = output.unwrap();
    let told = [output.stdout, output.stderr].concat();
    (String::from_utf8_lossy(&told).into_owned(), output.status.code())
}

/// Resident memory of the process, in bytes.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn resident() -> usize {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    pages.split_whitespace().nth(1).unwrap().parse::<usize>().unwrap() * 4096
}

/// Frees large blocks that lie between small ones, and returns what the process keeps of them.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn kept_after_freeing() -> usize {
    // The first large block that is freed makes the allocator keep the later ones.
    drop(std::hint::black_box(vec![1_u8; 8 * MB]));
    let before = resident();
    let blocks: Vec<(Vec<u8>, Vec<u8>)> = (0..32).map(|_| (vec![1; 4 * MB], vec![1; 64 << 10])).collect();
    assert!(resident() > before + 128 * MB);
    let (large, small): (Vec<_>, Vec<_>) = blocks.into_iter().unzip();
    drop(large);
    let kept = resident().saturating_sub(before);
    assert_eq!(small.iter().flatten().count(), 32 * (64 << 10));
    kept
}

/// Returns how many pages the process has asked the system for.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn faults() -> usize {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    let (_, fields) = stat.rsplit_once(')').unwrap();
    fields.split_whitespace().nth(7).unwrap().parse().unwrap()
}

/// Fills a large block twice, and returns how many pages the second time takes.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn pages_of_second_block() -> usize {
    drop(std::hint::black_box(vec![1_u8; 256 * MB]));
    let before = faults();
    drop(std::hint::black_box(vec![1_u8; 256 * MB]));
    faults() - before
}

fn task(name: &str) {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    if name == "large" {
        Heap::keep_freed();
        Heap::use_large_pages();
        let before = faults();
        drop(std::hint::black_box(vec![1_u8; 256 * MB]));
        return println!("{} pages", if faults() - before > 256 * MB / 4096 / 8 { "small" } else { "large" });
    }
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    if let "again" | "anew" = name {
        if name == "again" {
            Heap::keep_freed();
        }
        return println!("{} pages", if pages_of_second_block() > 64 { "many" } else { "few" });
    }
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    if let "keeping" | "returning" = name {
        if name == "returning" {
            Heap::return_large();
        }
        return println!("kept {}", if kept_after_freeing() > 64 * MB { "most" } else { "little" });
    }
    Heap::on_exhaustion(if name == "nothing left" { end_without_memory } else { end });
    match name {
        "bound" => {
            Heap::bound(Heap::taken() + 2 * MB);
            std::hint::black_box(vec![1_u8; 3 * MB]);
        }
        "many threads" => {
            Heap::bound(Heap::taken() + 2 * MB);
            std::thread::scope(|scope| {
                for _ in 0..8 {
                    scope.spawn(|| std::hint::black_box(vec![1_u8; 3 * MB]));
                }
            });
        }
        _ => {
            std::hint::black_box(vec![1_u8; isize::MAX as usize - 4096]);
        }
    }
    unreachable!("the program ends before");
}

fn main() {
    if let Ok(name) = std::env::var(TASK) {
        return task(&name);
    }
    let before = Heap::taken();
    let mut block: Vec<u8> = vec![1; 4 * MB];
    assert!((before + 4 * MB..before + 5 * MB).contains(&Heap::taken()));
    block.reserve_exact(12 * MB);
    assert!((before + 16 * MB..before + 17 * MB).contains(&Heap::taken()), "growing counts the difference");
    block.truncate(2 * MB);
    block.shrink_to_fit();
    assert!((before + 2 * MB..before + 3 * MB).contains(&Heap::taken()));
    drop(block);
    assert!(Heap::taken() < before + MB, "what is given back no longer counts");
    assert!(Heap::peak() >= before + 16 * MB);
    Heap::forget_peak();
    assert!(Heap::peak() < before + MB);

    Heap::bound(Heap::taken() + 8 * MB);
    assert!(Buffer::zeroed(16 * MB / 4, 0).is_err());
    let half = Buffer::zeroed(4 * MB / 4, 0).unwrap();
    assert!(Buffer::zeroed(6 * MB / 4, 0).is_err(), "together they go beyond the bound");
    drop(half);
    Buffer::zeroed(6 * MB / 4, 0).unwrap();
    assert!(fallible(|| vec![0_u8; MB].try_reserve(usize::MAX / 4)).is_err());
    Heap::bound(usize::MAX);

    let (told, code) = child("bound");
    assert!(told.contains(&format!("asked {}", 3 * MB)) && told.contains("bound Some"), "{told}");
    assert_eq!(code, Some(7), "it ends in order, and does not abort");
    assert_eq!(child("many threads").1, Some(7), "several threads end it once");
    let (told, code) = child("the system");
    assert!(told.contains("bound None"), "{told}");
    assert_eq!(code, Some(7));
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    for (name, kept) in
        [("keeping", "kept most"), ("returning", "kept little"), ("again", "few pages"), ("anew", "many pages")]
    {
        let (told, code) = child(name);
        assert!(told.contains(kept), "{name}: {told}");
        assert_eq!(code, Some(0));
    }
    // Not every system has large pages.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    if std::fs::read_to_string("/sys/kernel/mm/transparent_hugepage/enabled")
        .is_ok_and(|modes| !modes.contains("[never]"))
    {
        assert_eq!(child("large").0.trim(), "large pages");
    }
    let (told, code) = child("nothing left");
    assert!(told.contains("error: out of memory, even"), "{told}");
    assert_eq!(code, Some(1));
}
