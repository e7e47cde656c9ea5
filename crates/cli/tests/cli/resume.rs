//! `--resume` with damaged files.

use crate::scene::{SCENE, Scene};
use std::fs;

/// Returns an offset shortly behind the first mark in the bytes of a file.
fn mark(bytes: &[u8]) -> usize {
    let mark = b"trochoid:version";
    bytes.windows(mark.len()).position(|found| found == mark).unwrap() + 60
}

#[test]
fn files_that_are_cut_off_or_too_long_are_made_again() {
    let scene = Scene::new(SCENE);
    let render = || scene.run(&["render", "a.json", "--frames", "1", "--resume", "--error", "out/e.{output}.exr"]);
    render().code(0);
    for name in ["out/beauty.0001.exr", "out/mask.0001.png", "out/e.beauty.exr"] {
        let whole = fs::read(scene.path(name)).unwrap();
        let cut = |length: usize| whole[..length].to_vec();
        let zeroed = [&whole[..whole.len() - 30], &[0; 30]].concat();
        let mut damaged = vec![
            cut(whole.len() - 1),
            cut(whole.len() / 2),
            cut(mark(&whole)),
            [&whole[..], b"x"].concat(),
            [&whole[..], &whole].concat(),
        ];
        damaged.extend(name.ends_with(".png").then_some(zeroed));
        for bytes in damaged {
            fs::write(scene.path(name), &bytes).unwrap();
            render().code(0);
            assert!(fs::read(scene.path(name)).unwrap() == whole, "{name} of {} bytes", bytes.len());
            // The damaged file still counts as ours without --resume.
            fs::write(scene.path(name), &bytes).unwrap();
            let error: &[&str] = &["--error", "out/e.{output}.exr"];
            scene.run(&[&["render", "a.json", "--frames", "1"], error].concat()).code(0);
        }
        for theirs in [cut(20), b"\x89PNG\r\n\x1a\n".to_vec(), b"\x76\x2f\x31\x01\x02\0\0\0".to_vec()] {
            fs::write(scene.path(name), &theirs).unwrap();
            render().fails(2, &[name, "does not bear Trochoid's mark", "--overwrite"]);
            assert_eq!(fs::read(scene.path(name)).unwrap(), theirs);
        }
        fs::write(scene.path(name), &whole).unwrap();
        let again = render().code(0);
        assert!(again.out.contains("up to date"), "{}", again.out);
    }
}
