//! Which panels there are.

/// A panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub enum Pane {
    /// The picture.
    Viewer,
    /// The graph.
    Canvas,
    /// Knobs and connections of the chosen node.
    Properties,
    /// The sea that is chosen, as waves.
    Waves,
    /// What was evaluated and left out, and how long it took.
    Report,
    /// The document's text.
    Text,
}

impl Pane {
    /// Every panel.
    pub const ALL: [Self; 6] = [Self::Viewer, Self::Canvas, Self::Properties, Self::Waves, Self::Report, Self::Text];

    /// Its title.
    pub fn title(self) -> &'static str {
        match self {
            Self::Viewer => "Viewer",
            Self::Canvas => "Graph",
            Self::Properties => "Properties",
            Self::Waves => "Waves",
            Self::Report => "Report",
            Self::Text => "Text",
        }
    }
}
