//! Scripts that join the tiles of pictures.

use super::work::{TILES, Work, stem};
use std::fmt::Write as _;
use trochoid::{expand_frame, quoted, split_frame};

/// Returns the part of a script, in bash, that joins the tiles of all outputs at a frame. It expects the variables `frame`
/// and `out`, the folder of the pictures, and a function `run`, which runs a command.
pub(super) fn script(work: &Work) -> String {
    let mut text = String::from("digits=${frame#-}\nsign=${frame%\"$digits\"}\n\n");
    let count = work.tiles.len();
    let _ = writeln!(
        text,
        "# Joins the tiles of a picture, whose name is given without its ending.\n\
         join() {{\n    local tiles=() tile\n    for ((tile = 0; tile < {count}; tile++)); do\n        \
         tiles+=(\"$out/{TILES}/$1.t$(printf %04d \"$tile\").exr\")\n    done\n    \
         run \"$trochoid\" join \"${{tiles[@]}}\" -o \"$out/$1.exr\"\n}}\n"
    );
    let joins: Vec<String> = work.outputs.iter().map(|pattern| format!("join {}", name(stem(pattern)))).collect();
    text + &joins.join(" &&\n") + "\n"
}

/// Returns the name of a picture at the frame of a script as a word of the shell.
fn name(pattern: &str) -> String {
    match split_frame(pattern) {
        Some((before, width, after)) => {
            format!("{}\"$sign$(printf %0{width}d \"$digits\")\"{}", word(&before), word(&after))
        }
        None => word(&expand_frame(pattern, 0)),
    }
}

/// Quotes a part of a word, which may be empty.
fn word(text: &str) -> String {
    if text.is_empty() { String::new() } else { quoted(text) }
}
