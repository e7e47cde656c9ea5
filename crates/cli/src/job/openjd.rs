//! Templates of Open Job Description, 2023-09, with the extension `TASK_CHUNKING`.

use super::Files;
use super::folder::Content;
use super::work::{GRAPH, OUT, Work};
use super::{join, ranges};
use crate::failure::Failure;
use serde_json::{Value, json};
use trochoid::quoted;

/// Most signs of the value of a parameter.
const LONGEST: usize = 1024;
/// Most values of a parameter of tasks.
const MOST: usize = 1024;
/// Seconds that a command has to stop after it is asked to.
const NOTICE: u32 = 10;

/// Returns the template, and the values of its parameters that it cannot hold itself.
///
/// # Errors
/// A text has braces that the engine would read as an expression, or is too long.
pub(super) fn files(work: &Work) -> Result<Files, Failure> {
    Failure::all(faults(work))?;
    let mut steps = vec![render(work)];
    if !work.tiles.is_empty() {
        steps.push(join(work));
    }
    let template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "extensions": ["TASK_CHUNKING"],
        "name": format!("trochoid {}", work.name),
        "parameterDefinitions": parameters(work),
        "steps": steps,
    });
    let mut files = vec![("template.json".into(), text(&template))];
    if work.is_shared {
        let palette = work.palette.iter().map(|path| json!({ "name": "Palette", "value": path }));
        let values: Vec<Value> = [json!({ "name": "Graph", "value": work.graph })].into_iter().chain(palette).collect();
        files.push(("parameter_values.json".into(), text(&json!({ "parameterValues": values }))));
    }
    Ok(files)
}

fn text(value: &Value) -> Content {
    Content::Text(format!("{value:#}\n"))
}

/// Returns the parameters of the job.
fn parameters(work: &Work) -> Value {
    // A path outside of the folder cannot be a default; it is sent nowhere, because all machines reach it.
    let file = |name: &str, path: &str, what: &str| {
        let mut file = json!({ "name": name, "type": "PATH", "objectType": "FILE", "description": what });
        file["dataFlow"] = if work.is_shared { "NONE" } else { "IN" }.into();
        if !work.is_shared {
            file["default"] = path.into();
        }
        file
    };
    let mut all = vec![file("Graph", &work.graph, "The document")];
    if !work.is_shared {
        all.push(json!({
            "name": "Folder", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "IN", "default": GRAPH,
            "description": "The document and the files that it reads",
        }));
    }
    all.extend(work.palette.iter().map(|path| file("Palette", path, "Colors that replace those of the document")));
    all.extend([
        json!({
            "name": "Out", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "OUT", "default": OUT,
            "description": "The folder of the pictures, whose path has no # and no %",
        }),
        json!({ "name": "Frames", "type": "STRING", "default": ranges::list(&work.frames), "description": "Such as 1-10,20-40:2" }),
        json!({ "name": "Chunk", "type": "INT", "minValue": 1, "default": work.chunk, "description": "Most frames of a task" }),
        json!({ "name": "Threads", "type": "INT", "minValue": 0, "maxValue": 1024, "default": work.threads, "description": "0 uses all cores" }),
        json!({ "name": "Trochoid", "type": "STRING", "default": "trochoid", "description": "The program" }),
    ]);
    all.into()
}

/// Returns the parameter space of a step: its frames, and the product with what else there is.
fn space(work: &Work, frame: Value, with_tiles: bool) -> Value {
    let mut definitions = vec![frame];
    let mut product = Vec::new();
    let strings = |name: &str, range: Vec<String>| json!({ "name": name, "type": "STRING", "range": range });
    if let Some(wedge) = &work.wedge {
        definitions.push(strings("Wedge", wedge.values.clone()));
        definitions.push(strings("WedgeFolder", wedge.folders.clone()));
        product.push("(Wedge, WedgeFolder)");
    }
    if with_tiles && !work.tiles.is_empty() {
        let region = |[x, y, w, h]: &[u32; 4]| format!("{x},{y},{w},{h}");
        definitions.push(strings("Tile", (0..work.tiles.len()).map(|tile| format!("{tile:04}")).collect()));
        definitions.push(strings("Region", work.tiles.iter().map(region).collect()));
        product.push("(Tile, Region)");
    }
    product.push("Frame");
    json!({ "taskParameterDefinitions": definitions, "combination": product.join(" * ") })
}

fn render(work: &Work) -> Value {
    let rule = if ranges::is_contiguous(&work.frames) { "CONTIGUOUS" } else { "NONCONTIGUOUS" };
    let frame = json!({
        "name": "Frame", "type": "CHUNK[INT]", "range": "{{Param.Frames}}",
        "chunks": { "defaultTaskCount": "{{Param.Chunk}}", "rangeConstraint": rule },
    });
    let mut arguments: Vec<String> =
        ["render", "{{Param.Graph}}", "--frames", "{{Task.Param.Frame}}"].map(String::from).into();
    arguments.extend(work.palette.iter().map(|_| "--palette={{Param.Palette}}".into()));
    arguments.extend(work.options.iter().cloned());
    arguments.extend(work.wedge.iter().map(|wedge| format!("--set={}={{{{Task.Param.Wedge}}}}", wedge.knob)));
    let mut add = |option: &str, value: String| arguments.extend([option.into(), value]);
    let (before, after) = work.pattern_around();
    let tile = if work.tiles.is_empty() { "" } else { "{{Task.Param.Tile}}" };
    add("--out", format!("{}/{before}{tile}{after}", out(work)));
    if !work.tiles.is_empty() {
        add("--region", "{{Task.Param.Region}}".into());
    }
    add("--threads", "{{Param.Threads}}".into());
    add("--memory", format!("{}MiB", work.bound));
    add("--progress", "openjd".into());
    arguments.push("--resume".into());
    json!({
        "name": "Render",
        "parameterSpace": space(work, frame, true),
        "hostRequirements": requirements(work),
        "script": { "actions": { "onRun": action(work.minutes, "{{Param.Trochoid}}", arguments) } },
    })
}

fn join(work: &Work) -> Value {
    let frame = json!({ "name": "Frame", "type": "INT", "range": "{{Param.Frames}}" });
    let script = format!(
        "#!/bin/bash\n# Joins the tiles of all outputs at a frame: PROGRAM FOLDER FRAME\nset -euo pipefail\n\
         trochoid=$1 out=$2 frame=$3\nrun() {{ \"$@\"; }}\n{}",
        join::script(work)
    );
    let arguments = ["{{Task.File.Join}}", "{{Param.Trochoid}}", &out(work), "{{Task.Param.Frame}}"].map(String::from);
    json!({
        "name": "Join",
        "dependencies": [{ "dependsOn": "Render" }],
        "parameterSpace": space(work, frame, false),
        "script": {
            "actions": { "onRun": action(work.join_minutes, "bash", arguments.into()) },
            "embeddedFiles": [{ "name": "Join", "type": "TEXT", "filename": "join.sh", "data": script }],
        },
    })
}

/// Returns the folder of the pictures of a task.
fn out(work: &Work) -> String {
    format!("{{{{Param.Out}}}}{}", if work.wedge.is_some() { "/{{Task.Param.WedgeFolder}}" } else { "" })
}

fn action(minutes: u32, command: &str, arguments: Vec<String>) -> Value {
    json!({
        "command": command,
        "args": arguments,
        "timeout": u64::from(minutes) * 60,
        "cancelation": { "mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": NOTICE },
    })
}

fn requirements(work: &Work) -> Value {
    json!({ "amounts": [
        { "name": "amount.worker.vcpu", "min": work.threads },
        { "name": "amount.worker.memory", "min": work.memory() },
    ] })
}

/// Returns failures for what a template cannot hold.
fn faults(work: &Work) -> Vec<Failure> {
    let mut faults = Vec::new();
    let wedge = work.wedge.iter().flat_map(|wedge| std::iter::once(&wedge.knob).chain(&wedge.values));
    let paths = [&work.graph, &work.pattern].into_iter().chain(&work.palette);
    let texts: Vec<&String> = paths.chain(&work.options).chain(&work.outputs).chain(wedge).collect();
    for text in &texts {
        if text.contains("{{") || text.contains("}}") {
            let message = format!(
                "{}: found two braces in a row, which Open Job Description reads as an expression; expected none",
                quoted(text)
            );
            faults.push(Failure::usage(
                message,
                "put a space between them if it is a value, or give the file another name",
            ));
        }
        if text.chars().count() > LONGEST {
            let message = format!(
                "{}…: found a text of more than {LONGEST} signs",
                quoted(&text.chars().take(40).collect::<String>())
            );
            faults.push(Failure::usage(message + "; expected a shorter one", "set the value in the document"));
        }
    }
    let frames = ranges::list(&work.frames);
    if frames.len() > LONGEST {
        let message = format!("--frames: found a list of {} signs; expected at most {LONGEST}", frames.len());
        faults.push(Failure::usage(message, "make several jobs of it, or list ranges"));
    }
    if work.tiles.len() > MOST {
        let message = format!("--tiles: found {} tiles; expected at most {MOST}", work.tiles.len());
        faults.push(Failure::usage(message, "give fewer tiles"));
    }
    faults
}
