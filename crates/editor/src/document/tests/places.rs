use crate::document::json::{Op, Path, Splice, splice};

fn after(text: &str, op: Op) -> String {
    let splice = splice(text, &op).unwrap();
    let mut changed = text.to_string();
    splice.redo(&mut changed);
    let mut back = changed.clone();
    splice.undo(&mut back);
    assert_eq!(back, text, "undo gives the text back byte by byte");
    changed
}

fn at(steps: &[&str]) -> Path {
    steps.iter().fold(Path::default(), |path, step| match step.parse::<usize>() {
        Ok(index) => path.to(index),
        Err(_) => path.to(*step),
    })
}

#[test]
fn a_value_is_replaced_where_it_stands() {
    let text = "{ \"a\": [1,  2], \"b\":3 }";
    assert_eq!(after(text, Op::Set(at(&["a", "1"]), "7".into())), "{ \"a\": [1,  7], \"b\":3 }");
    assert_eq!(after(text, Op::Set(at(&["b"]), "{}".into())), "{ \"a\": [1,  2], \"b\":{} }");
}

#[test]
fn an_entry_is_added_as_its_neighbors_are() {
    assert_eq!(after("{ \"a\": 1 }", Op::Set(at(&["b"]), "2".into())), "{ \"a\": 1, \"b\": 2 }");
    assert_eq!(after("{\n  \"a\": 1\n}", Op::Set(at(&["b"]), "2".into())), "{\n  \"a\": 1,\n  \"b\": 2\n}");
    assert_eq!(
        after("{ \"a\": { \"x\": {} } }", Op::Set(at(&["a", "x", "y"]), "2".into())),
        "{ \"a\": { \"x\": { \"y\": 2 } } }"
    );
    assert_eq!(after("{ \"l\": [1] }", Op::Set(at(&["l", "1"]), "2".into())), "{ \"l\": [1, 2] }");
    assert_eq!(after("{ \"l\": [\n  1\n] }", Op::Insert(at(&["l", "0"]), "0".into())), "{ \"l\": [\n  0,\n  1\n] }");
}

#[test]
fn missing_parents_are_created() {
    let text = after("{}", Op::Set(at(&["ui", "positions", "a"]), "[1, 2]".into()));
    assert_eq!(text, "{\n  \"ui\": { \"positions\": { \"a\": [1, 2] } }\n}");
    assert!(splice("{}", &Op::Set(at(&["l", "3"]), "1".into())).is_err(), "a list has no holes");
}

#[test]
fn removed_entries_leave_nothing_behind() {
    let text = "{\n  \"a\": 1,\n  \"b\": 2,\n  \"c\": 3\n}";
    assert_eq!(after(text, Op::Remove(at(&["a"]))), "{\n  \"b\": 2,\n  \"c\": 3\n}");
    assert_eq!(after(text, Op::Remove(at(&["b"]))), "{\n  \"a\": 1,\n  \"c\": 3\n}");
    assert_eq!(after(text, Op::Remove(at(&["c"]))), "{\n  \"a\": 1,\n  \"b\": 2\n}");
    assert_eq!(after("{ \"a\": 1 }", Op::Remove(at(&["a"]))), "{}");
    assert_eq!(after("[1, 2, 3]", Op::Remove(at(&["1"]))), "[1, 3]");
    assert!(splice(text, &Op::Remove(at(&["d"]))).is_err());
    assert!(splice("[1]", &Op::Remove(at(&["1"]))).is_err());
}

#[test]
fn a_key_is_renamed_and_escaped() {
    assert_eq!(after("{ \"a\": 1 }", Op::Rename(at(&["a"]), "b\"c".into())), "{ \"b\\\"c\": 1 }");
}

#[test]
fn text_that_is_not_json_is_refused() {
    assert!(splice("{ \"a\": ", &Op::Remove(at(&["a"]))).is_err());
    assert!(splice("", &Op::Remove(at(&["a"]))).is_err());
    assert!(splice("{ // note\n }", &Op::Set(at(&["a"]), "1".into())).is_err(), "comments are no JSON");
}

#[test]
fn the_difference_of_texts_does_not_cut_characters() {
    for (old, new) in [("aäb", "aöb"), ("", "ä"), ("ää", "ä"), ("same", "same"), ("ab", "aab")] {
        let splice = Splice::between(old, new);
        let mut text = old.to_string();
        splice.redo(&mut text);
        assert_eq!(text, new);
        splice.undo(&mut text);
        assert_eq!(text, old);
    }
}
