//! Certificates of every node's golden case hold at every pixel.

use crate::support::{evaluate, folder, graph_in, root, settings};
use trochoid::certificate::{self, CertificateInputs, Choice, Request};
use trochoid::{Buffers, Cache, Certifier, CheckedGraph, Kind, OutputFile, Silent, registry, write_output};

/// Returns the failures of the certificates of a graph's outputs, each of which has its own file.
pub(crate) fn faults(graph: &CheckedGraph, frame: i64) -> Vec<String> {
    // A certificate may be in any folder, because its paths lead back to the inputs.
    let folder = tempfile::tempdir().unwrap();
    let picture = evaluate(graph, frame, &Buffers::new(), &settings(|_| ()));
    let certifier = Certifier::new(graph, &[], frame, &[], &settings(|_| ())).unwrap();
    let certified = certifier.certify(&Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    let mut faults = Vec::new();
    for (index, output) in graph.outputs().iter().enumerate() {
        let ending = if output.precision.is_some_and(|precision| precision.is_integer()) { "png" } else { "exr" };
        let file = OutputFile { path: folder.path().join(format!("{}.{ending}", output.name)), outputs: vec![index] };
        write_output(graph, &picture, &file, &[]).unwrap();
        let settings = settings(|_| ());
        let made = CertificateInputs { graph, file: &file, frame, certified: &certified, settings: &settings };
        let path = folder.path().join(format!("{}.json", output.name));
        let certificate = certificate::certify(&made, &path).unwrap();
        assert_eq!(certificate.outputs[0].controls.is_some(), output.kind == Kind::Color);
        certificate.write(&path, None).unwrap();
        let request = Request {
            certificate: &path,
            image: &file.path,
            choice: Choice::All,
            seed: 1,
            key: None,
            document: Some(graph),
            access: Some(graph.access()),
        };
        match certificate::verify(&request, &Silent) {
            Ok(found) => faults.extend(found.failures.iter().map(|failed| format!("{}: {failed}", output.name))),
            Err(error) => faults.push(format!("{}: {error}", output.name)),
        }
    }
    faults
}

#[test]
fn the_certificate_of_every_node_holds() {
    let (cases, folder) = (root().join("tests/nodes"), folder());
    let mut all = Vec::new();
    for node in registry().iter() {
        let ty = node.declaration().name;
        let text = std::fs::read_to_string(cases.join(format!("{ty}.json"))).unwrap();
        let graph = graph_in(folder.path(), &text);
        all.extend(faults(&graph, graph.frames().0).into_iter().map(|fault| format!("{ty}, {fault}")));
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}
