//! Certificates and error images, written next to the files of a run.

use super::accuracy::Accuracy;
use super::args::Args;
use super::written::{Written, take};
use crate::failure::{FAILED, Failure};
use crate::files::OverwriteOptions;
use serde_json::{Value, json};
use std::path::PathBuf;
use trochoid::accuracy::displayed_of;
use trochoid::certificate::{Certificate, CertificateInputs, CertifiedOutput, PrivateKey, certify, error_image, unit};
use trochoid::{
    Buffers, Cache, Certified, Certifier, CheckedGraph, CompanionPattern, Distribution, EvalError, Fingerprints, Form,
    Frame, InputFiles, Monitor, OutputFile, Settings, companion_files, quoted_path, write_guarded,
};

/// Companions of an output file: its certificate and error image, if requested.
#[derive(Clone, Debug, Default)]
pub(super) struct Companions {
    pub(super) certificate: Option<PathBuf>,
    pub(super) error: Option<PathBuf>,
}

impl Companions {
    /// Returns the companions of each file of a frame.
    pub(super) fn of(
        graph: &CheckedGraph,
        args: &Args,
        files: &[OutputFile],
        frame: i64,
        several: bool,
    ) -> Result<Vec<Self>, Failure> {
        let names = |option: &str, pattern: &Option<String>, ending: &str| match pattern {
            Some(pattern) => {
                let pattern = CompanionPattern { pattern, ending };
                companion_files(graph, files, frame, several, pattern)
                    .map_err(|error| Failure::written(&error, option))
                    .map(|names| names.into_iter().map(Some).collect::<Vec<_>>())
            }
            None => Ok(vec![None; files.len()]),
        };
        let (certificates, errors) =
            (names("--certificate", &args.certificate, ".json")?, names("--error", &args.error, ".exr")?);
        Ok(certificates.into_iter().zip(errors).map(|(certificate, error)| Self { certificate, error }).collect())
    }

    pub(super) fn paths(&self) -> impl Iterator<Item = (&'static str, &PathBuf, Form)> {
        let certificate = self.certificate.iter().map(|path| ("--certificate", path, Form::Certificate));
        certificate.chain(self.error.iter().map(|path| ("--error", path, Form::Error)))
    }

    /// Returns failures for companions that would overwrite an input or another file of the run.
    pub(super) fn refusals(&self, inputs: &InputFiles, written: &mut Written) -> Vec<Failure> {
        let faults = self.paths().filter_map(|(option, path, form)| {
            let taken = !take(path, form, written) || inputs.contains(path);
            taken.then(|| {
                let message = format!("{option} {}: is a file of the document or of the run", quoted_path(path));
                Failure::usage(message, "give it another name")
            })
        });
        faults.collect()
    }

    /// Returns whether all companions exist already and are up to date.
    pub(super) fn is_current(
        &self,
        graph: &CheckedGraph,
        file: &OutputFile,
        frame: i64,
        fingerprints: &mut Fingerprints,
        key: Option<&PrivateKey>,
    ) -> bool {
        let fingerprint = fingerprints.of(graph, file, frame);
        let key = key.map(PrivateKey::public);
        let is_current = |path: &PathBuf| Certificate::is_current(path, &fingerprint, key.as_ref());
        let certificate = self.certificate.as_ref().is_none_or(is_current);
        certificate && self.error.as_ref().is_none_or(|path| Fingerprints::is_marked(path, &fingerprint))
    }

    /// Adds the paths of the companions to the entry of a file in the report.
    pub(super) fn describe(&self, entry: &mut Value) {
        for (option, path, _) in self.paths() {
            entry[option.trim_start_matches('-')] = json!(path.display().to_string());
        }
    }
}

/// Data of a run that certifying needs.
pub(super) struct CertifyContext<'a> {
    pub(super) graph: &'a CheckedGraph,
    pub(super) settings: &'a Settings,
    /// Key that signs the certificates, if requested.
    pub(super) key: Option<&'a PrivateKey>,
    pub(super) over: OverwriteOptions,
}

impl CertifyContext<'_> {
    /// Certifies the files that were written for a frame, and writes their companions. Returns the bounds of samples,
    /// and what certificates say of each output.
    pub(super) fn run(
        &self,
        frame: &Frame,
        files: &[(&OutputFile, &Companions)],
        accuracy: &Accuracy,
        cache: &mut Cache,
        fingerprints: &mut Fingerprints,
        monitor: &dyn Monitor,
    ) -> Result<(Vec<Certified>, Vec<CertifiedOutput>), Failure> {
        let Self { graph, settings, key, over } = *self;
        if files.is_empty() {
            return Ok((Vec::new(), Vec::new()));
        }
        let number = frame.number;
        let failed = |error: &dyn std::fmt::Display| Failure::new(FAILED, format!("frame {number}: {error}"));
        let outputs: Vec<usize> = files.iter().flat_map(|(file, _)| file.outputs.iter().copied()).collect();
        let names: Vec<&str> = outputs.iter().map(|index| graph.outputs()[*index].name.as_str()).collect();
        let certified = match accuracy.known(number, &outputs) {
            Some(known) => known,
            None => {
                let certifier = Certifier::new(graph, &names, number, &[], settings).map_err(|error| failed(&error))?;
                certifier.certify(&Buffers::new(), cache, monitor).map_err(|error| match error {
                    EvalError::Cancelled => Failure::interrupted(),
                    error => Failure::evaluated(&format!("frame {number}: "), &error),
                })?
            }
        };
        let mut described = Vec::new();
        for (file, companions) in files {
            if let Some(path) = &companions.error {
                let metadata = fingerprints.metadata(graph, file, frame);
                error_image(graph, file, &certified, &metadata, path)?;
            }
            let made = CertificateInputs { graph, file, frame: number, certified: &certified, settings };
            let path = companions.certificate.as_ref();
            let certificate = certify(&made, path.unwrap_or(&file.path)).map_err(|error| failed(&error))?;
            if let Some(path) = path {
                write_guarded(path, certificate.sealed(key).as_bytes(), Form::Certificate, over.overwrite)?;
            }
            described.extend(certificate.outputs);
        }
        Ok((certified, described))
    }
}

/// Describes the certified errors of an output's samples, for reports.
pub(super) fn described(graph: &CheckedGraph, certified: &Certified) -> Value {
    let finite = |value: f64| if value.is_finite() { json!(value) } else { Value::Null };
    let shown = |error: f64| displayed_of(certified.kind, error, graph.space());
    let of = |samples: &Distribution| {
        let (max, p999) = (samples.max(), samples.quantile(0.999));
        json!({
            "samples": samples.total(),
            "max": finite(max),
            "p999": finite(p999),
            "displayed_max": shown(max),
            "displayed_p999": shown(p999),
        })
    };
    let all = certified.all();
    json!({
        "unit": unit(certified.kind, graph.space()),
        "clear": of(&certified.clear),
        "all": of(&all),
        "ambiguous_samples": certified.unclear.total(),
        "ambiguous_share": certified.unclear.total() as f64 / all.total().max(1) as f64,
        "ambiguous_share_beyond_8_bit": certified.in_doubt(1.0 / 255.0),
    })
}

/// Monitor for one half of a frame's work: rendering, then certifying.
pub(super) struct HalfMonitor<'m> {
    pub(super) monitor: &'m dyn Monitor,
    pub(super) second: bool,
}

impl Monitor for HalfMonitor<'_> {
    fn preparing(&self, node: &str) {
        self.monitor.preparing(node);
    }

    fn progress(&self, done: usize, total: usize) {
        self.monitor.progress(if self.second { total + done } else { done }, 2 * total);
    }

    fn cancelled(&self) -> bool {
        self.monitor.cancelled()
    }
}
