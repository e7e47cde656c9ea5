//! Texts that are no JSON, or beyond the limits.

use super::{Bad, SOUND, whole};

pub(super) fn table() -> Vec<Bad> {
    vec![
        whole("empty file", "", &[&["bad.json:1:1", "an empty file", "expected JSON", "write a document"]]),
        whole("only space", " \n \n", &[&["white space alone", "write a document"]]),
        whole("trailing comma", "{ \"trochoid\": 1,\n  }", &[&["bad.json:2:3", "trailing comma"]]),
        whole("comment", "{ // sea\n}", &[&["bad.json:1:3", "no comments"]]),
        whole("unclosed", "{ \"trochoid\": 1", &[&["EOF", "close every bracket and quote"]]),
        whole("unclosed text", "{ \"trochoid", &[&["EOF", "close every bracket and quote"]]),
        whole("two documents", format!("{SOUND} {{}}"), &[&["bad.json:2", "trailing characters"]]),
        whole("NaN literal", "{ \"trochoid\": NaN }", &[&["bad.json:1:15", "no NaN and no infinity"]]),
        whole("infinity literal", "{ \"trochoid\": -Infinity }", &[&["bad.json:1:1", "no NaN and no infinity"]]),
        whole("single quotes", "{ 'trochoid': 1 }", &[&["bad.json:1:3", "correct the syntax"]]),
        whole("leading zero", "{ \"trochoid\": 01 }", &[&["bad.json:1:1", "invalid number"]]),
        whole("bad escape", r#"{ "troch\oid": 1 }"#, &[&["bad.json:1", "invalid escape"]]),
        whole("lone surrogate", r#"{ "trochoid": 1, "notes": "\ud800" }"#, &[&["bad.json:1"]]),
        whole("control character", "{ \"a\u{1}b\": 1 }", &[&["bad.json:1", "control character"]]),
        whole("no object", "[1, 2]", &[&["bad.json:1:1", "a list of 2", "an object with \"trochoid\""]]),
        whole("a number", "7", &[&["bad.json:1:1: document: found 7", "write a JSON object"]]),
        whole(
            "100,000 levels",
            format!("{{ \"trochoid\": 1, \"notes\": {}{} }}", "[".repeat(100_000), "]".repeat(100_000)),
            &[&["nested"]],
        ),
        whole("100,000 open brackets", "[".repeat(100_000), &[&["bad.json:1:"]]),
        whole(
            "33 levels",
            format!("{{ \"notes\": {}{} }}", "[".repeat(40), "]".repeat(40)),
            &[&["nested deeper than 32 levels"]],
        ),
        whole("too large", " ".repeat((64 << 20) + 1), &[&["67108865 bytes", "at most 67108864", "several documents"]]),
        whole(
            "too many values",
            format!("{{ \"notes\": [{}0] }}", "0,".repeat(4_000_001)),
            &[&["more than 4000000 values"]],
        ),
        whole(
            "too many nodes",
            {
                let nodes: Vec<String> = (0..100_001).map(|i| format!(r#""n{i}": {{}}"#)).collect();
                format!(
                    r#"{{ "trochoid": 1, "format": {{ "width": 4, "height": 4 }}, "nodes": {{ {} }} }}"#,
                    nodes.join(",")
                )
            },
            &[&["100001 nodes", "at most 100000", "several documents"]],
        ),
    ]
}
