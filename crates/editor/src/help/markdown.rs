//! Markdown as blocks that can be drawn.

use pulldown_cmark::{CodeBlockKind, CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd};

/// A piece of text in one style.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) text: String,
    pub(super) code: bool,
    pub(super) strong: bool,
    pub(super) emphasis: bool,
    /// Where it leads.
    pub(super) link: Option<String>,
}

/// A part of a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Block {
    /// A heading of this level, from 1.
    Heading(usize, Vec<Span>),
    Text(Vec<Span>),
    /// An item of a list: depth from 0, and what stands before it.
    Item(usize, String, Vec<Span>),
    Code(String),
    /// The rows of a table; the first is its head.
    Table(Vec<Vec<Vec<Span>>>),
    Rule,
}

/// Reads a text.
pub(super) fn read(text: &str) -> Vec<Block> {
    let mut reader = Reader::default();
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        reader.take(event);
    }
    reader.end_text();
    reader.blocks
}

/// Returns the text of spans.
pub(super) fn plain(spans: &[Span]) -> String {
    spans.iter().map(|span| span.text.as_str()).collect()
}

/// Returns the name by which links lead to a heading.
pub(super) fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().replace(' ', "-");
    kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_')).collect()
}

#[derive(Default)]
struct Reader {
    blocks: Vec<Block>,
    spans: Vec<Span>,
    style: Span,
    /// The next number of each list that is open; `None` for bullets.
    lists: Vec<Option<u64>>,
    /// What stands before the item that has begun, until it has text.
    mark: Option<String>,
    /// The text of a code block.
    code: Option<String>,
    rows: Vec<Vec<Vec<Span>>>,
    in_table: bool,
    /// Nesting of pictures, whose texts are not drawn.
    pictures: usize,
}

impl Reader {
    fn take(&mut self, event: Event<'_>) {
        match event {
            Event::Start(tag) => self.start(tag),
            Event::End(end) => self.end(end),
            Event::Text(text) => self.text(&text),
            Event::Code(text) => {
                let span = Span { text: text.to_string(), code: true, ..self.style.clone() };
                self.push(span);
            }
            Event::SoftBreak => self.text(&CowStr::from(" ")),
            Event::HardBreak => self.text(&CowStr::from("\n")),
            Event::Rule => self.blocks.push(Block::Rule),
            // Comments, and rows that the book generates.
            _ => {}
        }
    }

    fn text(&mut self, text: &str) {
        match &mut self.code {
            Some(code) => code.push_str(text),
            None => {
                let span = Span { text: text.into(), ..self.style.clone() };
                self.push(span);
            }
        }
    }

    fn push(&mut self, span: Span) {
        if self.pictures > 0 {
            return;
        }
        match self.spans.last_mut() {
            Some(last)
                if Span { text: String::new(), ..last.clone() } == Span { text: String::new(), ..span.clone() } =>
            {
                last.text.push_str(&span.text);
            }
            _ => self.spans.push(span),
        }
    }

    fn start(&mut self, tag: Tag<'_>) {
        match tag {
            Tag::List(first) => {
                self.end_text();
                self.lists.push(first);
            }
            Tag::Item => {
                let mark = match self.lists.last_mut() {
                    Some(Some(number)) => {
                        *number += 1;
                        format!("{}.", *number - 1)
                    }
                    _ => "•".into(),
                };
                self.mark = Some(mark);
            }
            Tag::CodeBlock(CodeBlockKind::Fenced(_) | CodeBlockKind::Indented) => {
                self.end_text();
                self.code = Some(String::new());
            }
            Tag::Table(_) => {
                self.end_text();
                self.in_table = true;
            }
            Tag::TableHead | Tag::TableRow => self.rows.push(Vec::new()),
            Tag::Strong => self.style.strong = true,
            Tag::Emphasis => self.style.emphasis = true,
            Tag::Link { dest_url, .. } => self.style.link = Some(dest_url.to_string()),
            Tag::Image { .. } => self.pictures += 1,
            _ => {}
        }
    }

    fn end(&mut self, end: TagEnd) {
        match end {
            TagEnd::Heading(level) => {
                let spans = std::mem::take(&mut self.spans);
                self.blocks.push(Block::Heading(depth(level), spans));
            }
            TagEnd::Paragraph | TagEnd::Item => self.end_text(),
            TagEnd::List(_) => {
                self.lists.pop();
            }
            TagEnd::CodeBlock => {
                let code = self.code.take().unwrap_or_default();
                self.blocks.push(Block::Code(code.trim_end().into()));
            }
            TagEnd::TableCell => {
                let spans = std::mem::take(&mut self.spans);
                if let Some(row) = self.rows.last_mut() {
                    row.push(spans);
                }
            }
            TagEnd::Table => {
                self.in_table = false;
                self.blocks.push(Block::Table(std::mem::take(&mut self.rows)));
            }
            TagEnd::Strong => self.style.strong = false,
            TagEnd::Emphasis => self.style.emphasis = false,
            TagEnd::Link => self.style.link = None,
            TagEnd::Image => self.pictures -= 1,
            _ => {}
        }
    }

    /// Ends a paragraph, or the text of an item.
    fn end_text(&mut self) {
        let spans = std::mem::take(&mut self.spans);
        if plain(&spans).trim().is_empty() {
            return;
        }
        self.blocks.push(match self.lists.len() {
            0 => Block::Text(spans),
            depth => Block::Item(depth - 1, self.mark.take().unwrap_or_default(), spans),
        });
    }
}

fn depth(level: HeadingLevel) -> usize {
    level as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(text: &str) -> Span {
        Span { text: text.into(), ..Span::default() }
    }

    #[test]
    fn a_text_becomes_blocks() {
        let text = "# A sea\n\nSee [the *waves*](sea.md#waves), `Mix`\nand more.\n\n- one\n  - two\n\n2. three\n\n       code\n\n| a | b |\n|---|---|\n| `c` | d |\n\n![a picture](a.png)\n";
        let link = |text: &str, emphasis| Span { link: Some("sea.md#waves".into()), emphasis, ..span(text) };
        let blocks = read(text);
        assert_eq!(blocks[0], Block::Heading(1, vec![span("A sea")]));
        let code = Span { code: true, ..span("Mix") };
        let words = vec![span("See "), link("the ", false), link("waves", true), span(", "), code, span(" and more.")];
        assert_eq!(blocks[1], Block::Text(words));
        assert_eq!(blocks[2], Block::Item(0, "•".into(), vec![span("one")]));
        assert_eq!(blocks[3], Block::Item(1, "•".into(), vec![span("two")]));
        assert_eq!(blocks[4], Block::Item(0, "2.".into(), vec![span("three")]));
        assert_eq!(blocks[5], Block::Code("code".into()));
        let Block::Table(rows) = &blocks[6] else { panic!("{:?}", blocks[6]) };
        let cells: Vec<Vec<String>> = rows.iter().map(|row| row.iter().map(|cell| plain(cell)).collect()).collect();
        assert_eq!(cells, [["a", "b"], ["c", "d"]]);
        assert_eq!(blocks.len(), 7, "pictures are left out");
    }

    #[test]
    fn links_lead_to_headings() {
        assert_eq!(anchor("How do I …"), "how-do-i-");
        assert_eq!(anchor("Links and formulas"), "links-and-formulas");
    }
}
