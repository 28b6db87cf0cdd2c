//! Shared parts of the fuzz targets: a folder to load from, an allocator that counts, and the
//! invariants of loaded scenes.
//!
//! From the root of the workspace, with a nightly compiler and `cargo install cargo-fuzz`:
//!
//! ```text
//! cargo +nightly fuzz run ply fuzz/corpus/ply crates/scene/tests/corpus/ply -- \
//!     -max_len=2048 -max_total_time=900
//! ```
//!
//! and likewise for `obj`, `mtl`, `swc`, `tck`, `trk`, `points`, `scene` and `texture`. A file of
//! `trk` has a header of 1000 bytes. Add failing inputs to `crates/scene/tests/corpus/`, which
//! `cargo test` replays.

use rotund_scene::{LoadOptions, load};
use std::{
    alloc::{GlobalAlloc, Layout, System},
    fs,
    path::PathBuf,
    sync::{
        LazyLock,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
};

#[path = "../../crates/scene/tests/support/input.rs"]
mod input;
#[path = "../../crates/scene/tests/support/whole.rs"]
mod whole;

/// Loads the scene that `bytes` are to `target`.
///
/// # Panics
///
/// If what loads does not hold together, or if loading takes more than `ratio` times the length of
/// the files, a fixed amount, which is what the readers' own buffers and tables take, and `more`.
pub fn survives(target: &str, bytes: &[u8], ratio: usize, more: usize) {
    let Some((name, file, scene)) = input::files(target, bytes) else { return };
    static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
        // The hook of libFuzzer ends the process, also at a panic that the loaders catch. One that
        // they do not catch still ends it, when it gets to the fuzzer.
        std::panic::set_hook(Box::new(|panic| eprintln!("{panic}")));
        let folder = tempfile::tempdir().expect("a temporary folder").keep();
        // Create threads and tables first, since they are allocated once.
        let warm = folder.join("warm.json");
        fs::write(
            &warm,
            r#"{ "shapes": [{ "generator": { "disk": { "steps": 2, "radius": 1 } } }] }"#,
        )
        .expect("writes the scene");
        load(&warm, &LoadOptions::default()).expect("loads");
        folder
    });
    // The tables of one compression of EXR take a few megabytes.
    const FIXED: usize = 1 << 23;
    fs::write(FOLDER.join(&name), &file).expect("writes the file");
    fs::write(FOLDER.join(input::MESH.0), input::MESH.1).expect("writes the mesh");
    fs::write(FOLDER.join("scene.json"), &scene).expect("writes the scene");
    // The sky around a lone shape takes a hundred times as long as the shape of such a file, so few
    // inputs are loaded that way: those whose sum is a multiple of 16.
    let sum = bytes.iter().fold(0_u8, |sum, &byte| sum.wrapping_add(byte));
    let lone = input::lone(target, &name).filter(|_| sum % 16 == 0);
    // The floor and the sky take as much memory again.
    let loads = [Some(("scene.json".to_owned(), FIXED)), lone.map(|lone| (lone, 4 * FIXED))];
    for (name, fixed) in loads.into_iter().flatten() {
        let before = LIVE.load(Relaxed);
        PEAK.store(before, Relaxed);
        let loaded = load(FOLDER.join(name), &LoadOptions::default());
        let taken = PEAK.load(Relaxed).saturating_sub(before);
        let allowed = fixed + more + ratio * (file.len() + scene.len());
        assert!(taken <= allowed, "{taken} bytes of memory for {} of a file", file.len());
        if let Ok(loaded) = loaded {
            whole::check(&loaded.scene);
        }
    }
}

/// The system allocator, counting the bytes in use.
struct Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn add(size: usize) {
    PEAK.fetch_max(LIVE.fetch_add(size, Relaxed) + size, Relaxed);
}

// SAFETY: every call is forwarded unchanged to the system allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        // SAFETY: the caller upholds the same contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Old and new block exist at once when the system moves them.
        add(size);
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}
