//! Scripts of Slurm: job arrays.

use super::Files;
use super::folder::Content;
use super::join;
use super::work::{OUT, Work};
use std::fmt::Write as _;
use trochoid::quoted;

/// Runs a command so that a signal to the script reaches it; the exit code is in `code` then.
const RUN: &str = r#"run() {
    local stopped=
    "$@" &
    trap 'stopped=1; kill -TERM "$!" 2> /dev/null' TERM
    wait "$!"
    code=$?
    # The signal ended the wait; the command has yet to end.
    if [ -n "$stopped" ]; then
        wait "$!"
        code=$?
    fi
    return "$code"
}
"#;

/// Ends a task. Only what may succeed elsewhere is tried again: failed input, output or memory (1), and the end by a
/// signal, which also ends what takes more memory than the machine has (129 and more, except for the interruption that
/// Slurm itself asks for, 130 and 143). An invalid document (2) and a missed guarantee (3) stay so.
const END: &str = r#"case $code in
    0) exit 0 ;;
    126 | 127) echo "$trochoid cannot be run on $(hostname): export TROCHOID=/PATH/OF/trochoid and submit again" >&2 ;;
    1 | 129 | 13[1-9] | 14[0-24-9] | 1[5-9]?)
        if [ "${SLURM_RESTART_COUNT:-0}" -lt 3 ]; then
            echo "ended with code $code: trying again" >&2
            scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
        fi
        ;;
esac
exit "$code"
"#;

/// Returns the scripts.
pub(super) fn files(work: &Work) -> Files {
    let mut files = vec![("job.sh".into(), Content::Text(render(work)))];
    if !work.tiles.is_empty() {
        files.push(("join.sh".into(), Content::Text(join(work))));
    }
    files.push(("submit.sh".into(), Content::Text(submit(work))));
    files
}

/// Returns the beginning of a script: the options of `sbatch`.
fn head(work: &Work, name: &str, tasks: usize, threads: u16, minutes: u32) -> String {
    let (job, last, memory) = (&work.name, tasks - 1, work.memory());
    format!(
        "#!/bin/bash\n\
         #SBATCH --job-name={name}.{job}\n\
         #SBATCH --array=0-{last}\n\
         #SBATCH --ntasks=1\n\
         #SBATCH --cpus-per-task={threads}\n\
         #SBATCH --mem={memory}M\n\
         #SBATCH --time={minutes}\n\
         #SBATCH --signal=B:TERM@30\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         #SBATCH --output=logs/%x.%A_%a.log\n\
         # Submitted by submit.sh, in this folder, which all machines must reach.\n\
         set -u\n\
         trochoid=${{TROCHOID:-trochoid}}\n\
         task=$SLURM_ARRAY_TASK_ID\n\n"
    )
}

/// Returns a list as an array of bash, one element a line.
fn array(name: &str, values: impl IntoIterator<Item = String>) -> String {
    let lines: String = values.into_iter().map(|value| format!("    {}\n", quoted(&value))).collect();
    format!("{name}=(\n{lines})\n")
}

/// Returns the line that sets the folder of the pictures, which is chosen by `at` if there is a wedge.
fn folder(work: &Work, at: &str) -> String {
    match &work.wedge {
        Some(wedge) => array("folders", wedge.folders.iter().cloned()) + &format!("out={OUT}/${{folders[{at}]}}\n"),
        None => format!("out={OUT}\n"),
    }
}

fn render(work: &Work) -> String {
    let (chunks, tiles) = (work.chunks(), work.tiles.len().max(1));
    let count = chunks.len();
    let mut text = head(work, "trochoid", work.tasks(), work.threads, work.minutes);
    text += &array("chunks", chunks);
    let _ = writeln!(text, "frames=${{chunks[task % {count}]}}");
    if !work.tiles.is_empty() {
        text += &array("regions", work.tiles.iter().map(|[x, y, w, h]| format!("{x},{y},{w},{h}")));
        let _ = writeln!(text, "tile=$((task / {count} % {tiles}))\nregion=${{regions[tile]}}");
        text += "number=$(printf %04d \"$tile\")\n";
    }
    let at = format!("task / {}", count * tiles);
    if let Some(wedge) = &work.wedge {
        text += &array("values", wedge.assignments());
        let _ = writeln!(text, "value=${{values[{at}]}}");
    }
    text += &folder(work, &at);
    let mut words = vec!["\"$trochoid\" render".to_owned(), quoted(&work.graph), "--frames \"$frames\"".into()];
    words.extend(work.palette.iter().map(|path| format!("--palette {}", quoted(path))));
    words.extend(work.options.iter().map(|option| quoted(option)));
    words.extend(work.wedge.iter().map(|_| "--set=\"$value\"".into()));
    let (before, after) = work.pattern_around();
    let tile = if work.tiles.is_empty() { "" } else { "\"$number\"" };
    words.push(format!("--out \"$out\"/{}{tile}{after}", quoted(&before)));
    if !work.tiles.is_empty() {
        words.push("--region \"$region\"".into());
    }
    words.push(format!("--threads {} --memory {}MiB --resume", work.threads, work.bound));
    let _ = write!(text, "\n{RUN}run {}\n{END}", words.join(" \\\n    "));
    text
}

fn join(work: &Work) -> String {
    let mut text = head(work, "join", work.joins(), 1, work.join_minutes);
    let count = work.frames.len();
    text += &array("frames", work.frames.iter().map(ToString::to_string));
    let _ = writeln!(text, "frame=${{frames[task % {count}]}}");
    text += &folder(work, &format!("task / {count}"));
    let _ = write!(text, "\n{RUN}{}{END}", join::script(work));
    text
}

fn submit(work: &Work) -> String {
    let mut text = String::from(
        "#!/bin/bash\n# Submits the job; options are those of sbatch, such as --partition=night.\nset -euo pipefail\n\
         cd -- \"$(dirname -- \"${BASH_SOURCE[0]}\")\"\nmkdir -p logs\n",
    );
    text += if work.tiles.is_empty() {
        "exec sbatch \"$@\" job.sh\n"
    } else {
        "render=$(sbatch --parsable \"$@\" job.sh)\necho \"Submitted batch job ${render%%;*}\"\n\
         sbatch --dependency=\"afterok:${render%%;*}\" --kill-on-invalid-dep=yes \"$@\" join.sh\n"
    };
    text
}
