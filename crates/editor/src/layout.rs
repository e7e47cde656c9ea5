//! Which panels there are, and where they lie.

use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};

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

/// Panels as they lie at first: the picture above the graph, what belongs to the chosen node at the right.
pub fn first() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let viewer = tiles.insert_pane(Pane::Viewer);
    let canvas = tiles.insert_pane(Pane::Canvas);
    let side: Vec<TileId> =
        [Pane::Properties, Pane::Waves, Pane::Report, Pane::Text].map(|pane| tiles.insert_pane(pane)).into();
    let first = side[0];
    let side = tiles.insert_tab_tile(side);
    if let Some(Tile::Container(Container::Tabs(tabs))) = tiles.get_mut(side) {
        tabs.set_active(first);
    }
    let main = Linear::new_binary(LinearDir::Vertical, [viewer, canvas], 0.56);
    let main = tiles.insert_container(main);
    let root = tiles.insert_container(Linear::new_binary(LinearDir::Horizontal, [main, side], 0.72));
    Tree::new("panels", root, tiles)
}

/// Brings a panel to the front, also one that was closed.
pub fn bring(tree: &mut Tree<Pane>, pane: Pane) {
    let Some(tile) = tree.tiles.find_pane(&pane) else {
        *tree = first();
        return;
    };
    tree.set_visible(tile, true);
    tree.make_active(|id, _| id == tile);
}
