//! Reads texts for users from documentation comments.

use syn::spanned::Spanned;
use syn::{Attribute, Error, Expr, ExprLit, Lit, Meta};

/// Returns the lines of a documentation comment.
fn lines(attributes: &[Attribute]) -> Vec<String> {
    let docs = attributes.iter().filter(|attribute| attribute.path().is_ident("doc"));
    let texts = docs.filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    });
    texts.map(|line| line.trim().to_owned()).collect()
}

/// Joins lines into one text; an empty line starts a paragraph.
fn joined(lines: &[String]) -> String {
    let paragraphs = lines.split(|line| line.is_empty()).filter(|lines| !lines.is_empty());
    paragraphs.map(|lines| lines.join(" ")).collect::<Vec<_>>().join("\n\n")
}

/// Returns the whole comment as one text.
pub(crate) fn help(attributes: &[Attribute], what: &impl Spanned) -> Result<String, Error> {
    let text = joined(&lines(attributes));
    if text.is_empty() { Err(Error::new(what.span(), "describe it in a comment: /// …")) } else { Ok(text) }
}

/// Documentation comment of a node, in sections.
pub(crate) struct Sections {
    pub(crate) summary: String,
    pub(crate) formula: String,
    pub(crate) edge_cases: String,
    pub(crate) source: String,
}

impl Sections {
    pub(crate) fn of(attributes: &[Attribute], what: &impl Spanned) -> Result<Self, Error> {
        const HEADINGS: [&str; 3] = ["# Formula", "# Edge cases", "# Source"];
        let lines = lines(attributes);
        let mut parts = vec![Vec::new()];
        for line in lines {
            if line.starts_with("# ") {
                if HEADINGS.get(parts.len() - 1) != Some(&line.as_str()) {
                    let expected = HEADINGS.get(parts.len() - 1).unwrap_or(&"no more");
                    return Err(Error::new(what.span(), format!("found the heading \"{line}\", expected {expected}")));
                }
                parts.push(Vec::new());
            } else if let Some(part) = parts.last_mut() {
                part.push(line);
            }
        }
        let texts: Vec<String> = parts.iter().map(|part| joined(part)).collect();
        match <[String; 4]>::try_from(texts) {
            Ok([summary, formula, edge_cases, source]) if !summary.is_empty() => {
                Ok(Self { summary, formula, edge_cases, source })
            }
            _ => {
                let expected = "document the node: a sentence, then # Formula, # Edge cases and # Source";
                Err(Error::new(what.span(), expected))
            }
        }
    }
}
