//! The outputs of a run: those of the document, and recipes of its colors.

use super::args::Args;
use crate::failure::Failure;
use crate::outputs;
use trochoid::{CheckedGraph, Kind, LoadError, OutputError, OutputFile, Tolerance, output_files};

/// The outputs of a run.
pub(super) struct Chosen {
    /// The document, with an output for each recipe that only the command line asks for.
    pub(super) graph: CheckedGraph,
    /// The same graph with recipes, if there are any, as it is evaluated.
    with_recipes: Option<CheckedGraph>,
    /// Outputs of the document.
    pub(super) outputs: Vec<usize>,
    /// Recipes for `--recipe`.
    recipes: Vec<usize>,
}

impl Chosen {
    /// Chooses outputs, and adds all faults to `faults`.
    pub(super) fn new(mut graph: CheckedGraph, args: &Args, faults: &mut Vec<Failure>) -> Self {
        let outputs = match args.view.len() {
            0 => outputs::choose(&graph, &args.output, faults),
            // They are the last ones.
            views => (graph.outputs().len() - views..graph.outputs().len()).collect(),
        };
        let mut recipes = Vec::new();
        if args.recipe.is_some() {
            let colors = outputs.iter().copied().filter(|index| {
                let spec = &graph.outputs()[*index];
                spec.kind == Kind::Color && !spec.is_recipe
            });
            let colors: Vec<usize> = colors.collect();
            if colors.is_empty() {
                let message = "--recipe: found no output that is a color; expected one, whose weights a recipe holds";
                faults.push(Failure::usage(message, "choose another output: --output NAME"));
            }
            recipes.extend(colors.into_iter().map(|of| graph.add_recipe(of, args.float)));
        }
        let mut chosen = Self { graph, with_recipes: None, outputs, recipes };
        let all = chosen.all();
        if chosen.graph.has_recipe(&all) {
            faults.extend(chosen.refused(args));
            match chosen.graph.clone().with_recipes(&all) {
                Ok(graph) => chosen.with_recipes = Some(graph),
                Err(refused) => faults.push(LoadError::Invalid(refused).into()),
            }
        }
        chosen
    }

    /// Returns all outputs that are evaluated.
    fn all(&self) -> Vec<usize> {
        [&self.outputs[..], &self.recipes].concat()
    }

    /// Returns the graph that is evaluated.
    pub(super) fn evaluated(&self) -> &CheckedGraph {
        self.with_recipes.as_ref().unwrap_or(&self.graph)
    }

    /// Names the files of a frame.
    pub(super) fn files(
        &self,
        graph: &CheckedGraph,
        args: &Args,
        frame: i64,
        several: bool,
    ) -> Result<Vec<OutputFile>, Failure> {
        let mut files = output_files(graph, &self.outputs, frame, several, args.out.as_deref())?;
        if let Some(pattern) = &args.recipe {
            let named = output_files(graph, &self.recipes, frame, several, Some(pattern));
            files.extend(named.map_err(|error: OutputError| Failure::written(&error, "--recipe"))?);
        }
        Ok(files)
    }

    /// Whether a file holds a recipe. Its weights have no certificate.
    pub(super) fn is_recipe(&self, file: &OutputFile) -> bool {
        self.graph.has_recipe(&file.outputs)
    }

    /// Returns failures for what cannot be done with recipes.
    fn refused(&self, args: &Args) -> Vec<Failure> {
        let asked = args.tolerance(&self.graph);
        let refused = [
            ("--certificate", args.certificate.is_some(), "pictures"),
            ("--error", args.error.is_some(), "pictures"),
            ("the tolerance \"reference\"", asked == Some(Tolerance::Reference), "colors"),
        ];
        let refused = refused.into_iter().filter(|(_, is_given, _)| *is_given).map(|(what, _, expected)| {
            let message = format!("{what}: found a recipe among the outputs; expected {expected} alone");
            Failure::usage(message, "render the recipe in a run of its own")
        });
        refused.collect()
    }
}
