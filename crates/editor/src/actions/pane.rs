//! The editor's panels.

/// A panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub enum Pane {
    /// The picture.
    Viewer,
    /// Another picture.
    Second,
    /// The graph.
    Canvas,
    /// Knobs and connections of the selected node.
    Properties,
    /// Colors of the document.
    Palette,
    /// Keyed values as curves, and the dope sheet.
    Curves,
    /// Spectrum of the selected sea, as waves.
    Waves,
    /// Nodes that were evaluated or left out, with timings.
    Report,
    /// The document's text.
    Text,
    /// The manual.
    Help,
}

impl Pane {
    /// Every panel, in menu order.
    pub const ALL: [Self; 10] = [
        Self::Viewer,
        Self::Second,
        Self::Canvas,
        Self::Properties,
        Self::Palette,
        Self::Curves,
        Self::Waves,
        Self::Report,
        Self::Text,
        Self::Help,
    ];

    /// Returns the panel's title.
    pub fn title(self) -> &'static str {
        match self {
            Self::Viewer => "Viewer",
            Self::Second => "Viewer 2",
            Self::Canvas => "Graph",
            Self::Properties => "Properties",
            Self::Palette => "Palette",
            Self::Curves => "Curves",
            Self::Waves => "Waves",
            Self::Report => "Report",
            Self::Text => "Text",
            Self::Help => "Help",
        }
    }
}
