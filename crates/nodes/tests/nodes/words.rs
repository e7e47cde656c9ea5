//! The names of nodes, and those that other programs give them.

use std::collections::BTreeSet;
use trochoid_graph::{OUTPUT_WORDS, Registry, Term, refusal};

#[test]
fn each_word_of_other_programs_means_one_thing_and_none_is_refused() {
    let registry = Registry::new(trochoid_nodes::all());
    let aliases = registry.iter().flat_map(|ty| ty.declaration().aliases).map(|alias| alias.word);
    let mut known: BTreeSet<String> = registry.names().map(str::to_lowercase).collect();
    for word in aliases.chain(OUTPUT_WORDS) {
        assert!(refusal(word).is_none(), "{word} is refused");
        assert!(
            known.insert(word.to_lowercase()),
            "\"{word}\" names two nodes, or one twice: remove it from the also_called of one"
        );
    }
    assert_eq!(Term::of("image_read", &registry).and_then(|term| term.node()), Some("Read"));
    assert!(Term::of("Read", &registry).is_none() && Term::of("", &registry).is_none());
    assert_eq!(Term::of("file output", &registry), Some(Term::Output));
}
