//! Layout of the panels, and its storage.

use crate::actions::{Layout, Pane};
use egui::ThemePreference;
use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};
use std::collections::HashSet;

/// Returns the initial layout: the viewer above the graph, panels for the selected node on the right.
pub fn first() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let viewer = viewers(&mut tiles);
    let canvas = tiles.insert_pane(Pane::Canvas);
    let curves = tiles.insert_pane(Pane::Curves);
    let side: Vec<TileId> = [Pane::Properties, Pane::Palette, Pane::Waves, Pane::Report, Pane::Text, Pane::Help]
        .map(|pane| tiles.insert_pane(pane))
        .into();
    let first = side[0];
    let side = tiles.insert_tab_tile(side);
    if let Some(Tile::Container(Container::Tabs(tabs))) = tiles.get_mut(side) {
        tabs.set_active(first);
    }
    let below = tiles.insert_tab_tile(vec![canvas, curves]);
    if let Some(Tile::Container(Container::Tabs(tabs))) = tiles.get_mut(below) {
        tabs.set_active(canvas);
    }
    let main = Linear::new_binary(LinearDir::Vertical, [viewer, below], 0.56);
    let main = tiles.insert_container(main);
    let root = tiles.insert_container(Linear::new_binary(LinearDir::Horizontal, [main, side], 0.72));
    Tree::new("panels", root, tiles)
}

/// Inserts the viewers: the second one stands beside the first one, as soon as it is opened.
fn viewers(tiles: &mut Tiles<Pane>) -> TileId {
    let viewers = [Pane::Viewer, Pane::Second].map(|pane| tiles.insert_pane(pane));
    tiles.set_visible(viewers[1], false);
    tiles.insert_container(Linear::new_binary(LinearDir::Horizontal, viewers, 0.5))
}

/// Brings a panel to the front, including one that was closed.
pub fn bring(tree: &mut Tree<Pane>, pane: Pane) {
    let Some(tile) = tree.tiles.find_pane(&pane) else {
        *tree = first();
        return;
    };
    tree.set_visible(tile, true);
    tree.make_active(|id, _| id == tile);
}

/// Returns the arrangement of the panels that a layout is.
pub fn arranged(layout: Layout) -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let viewer = viewers(&mut tiles);
    let mut pane = |pane: Pane| tiles.insert_pane(pane);
    let canvas = pane(Pane::Canvas);
    let first = match layout {
        Layout::First => return first(),
        Layout::Painting => Pane::Palette,
        Layout::Animation => Pane::Curves,
    };
    // Panels that have no place of their own are tabs.
    let placed = [Pane::Viewer, Pane::Second, Pane::Canvas];
    let others: Vec<TileId> = Pane::ALL.into_iter().filter(|other| !placed.contains(other)).map(&mut pane).collect();
    let front = others.iter().copied().find(|id| tiles.get(*id) == Some(&Tile::Pane(first)));
    let tabs = tiles.insert_tab_tile(others);
    if let (Some(Tile::Container(Container::Tabs(tabs))), Some(front)) = (tiles.get_mut(tabs), front) {
        tabs.set_active(front);
    }
    let mut binary = |direction, children, share| {
        let linear = Linear::new_binary(direction, children, share);
        tiles.insert_container(linear)
    };
    let root = match layout {
        Layout::First | Layout::Painting => {
            let side = binary(LinearDir::Vertical, [tabs, canvas], 0.6);
            binary(LinearDir::Horizontal, [viewer, side], 0.66)
        }
        Layout::Animation => {
            let top = binary(LinearDir::Horizontal, [viewer, canvas], 0.55);
            binary(LinearDir::Vertical, [top, tabs], 0.6)
        }
    };
    Tree::new("panels", root, tiles)
}

/// Version of the stored layout; increment when its meaning changes.
const VERSION: u32 = 1;

/// Stored state of the window.
#[derive(serde::Serialize, serde::Deserialize)]
struct StoredLayout<T> {
    version: u32,
    panels: T,
    theme: ThemePreference,
    /// Zoom factor of the interface.
    #[serde(default = "unscaled")]
    zoom: f32,
}

fn unscaled() -> f32 {
    1.0
}

/// Serializes panels, theme, and zoom factor.
pub fn written(panels: &Tree<Pane>, (theme, zoom): (ThemePreference, f32)) -> String {
    // If serialization fails, the next start uses the initial layout.
    serde_json::to_string(&StoredLayout { version: VERSION, panels, theme, zoom }).unwrap_or_default()
}

/// Parses a stored layout; returns `None` if it is damaged or from a version with other panels.
pub fn read(text: &str) -> Option<(Tree<Pane>, (ThemePreference, f32))> {
    let mut kept: StoredLayout<Tree<Pane>> = serde_json::from_str(text).ok()?;
    complete(&mut kept.panels);
    let legal = kept.version == VERSION && is_whole(&kept.panels) && (0.2..=5.0).contains(&kept.zoom);
    legal.then_some((kept.panels, (kept.theme, kept.zoom)))
}

/// Adds panels that the editor did not have when a layout was stored: as tabs beside the properties.
fn complete(tree: &mut Tree<Pane>) {
    let tabs = tree.tiles.find_pane(&Pane::Properties).and_then(|properties| tree.tiles.parent_of(properties));
    let missing = Pane::ALL.into_iter().filter(|pane| tree.tiles.find_pane(pane).is_none());
    for pane in missing.collect::<Vec<Pane>>() {
        let new = tree.tiles.insert_pane(pane);
        if let Some(Tile::Container(Container::Tabs(tabs))) = tabs.and_then(|tabs| tree.tiles.get_mut(tabs)) {
            tabs.add_child(new);
        }
        // It opens when it is asked for.
        tree.set_visible(new, pane != Pane::Second);
    }
}

/// Returns whether every panel is reachable exactly once and has a size.
fn is_whole(tree: &Tree<Pane>) -> bool {
    let mut open: Vec<TileId> = tree.root.into_iter().collect();
    let mut seen = HashSet::new();
    let mut panes = Vec::new();
    while let Some(id) = open.pop() {
        // A tile in two places, or inside itself, cannot be drawn.
        if !seen.insert(id) {
            return false;
        }
        match tree.tiles.get(id) {
            None => return false,
            Some(Tile::Pane(pane)) => panes.push(*pane),
            Some(Tile::Container(container)) => {
                let mut shares: Box<dyn Iterator<Item = f32>> = match container {
                    Container::Linear(linear) => Box::new(linear.shares.iter().map(|(_, share)| *share)),
                    Container::Grid(grid) => Box::new(grid.col_shares.iter().chain(&grid.row_shares).copied()),
                    Container::Tabs(_) => Box::new(std::iter::empty()),
                };
                if !shares.all(|share| share.is_finite() && share > 0.0) {
                    return false;
                }
                open.extend(container.children());
            }
        }
    }
    panes.len() == Pane::ALL.len() && Pane::ALL.iter().all(|pane| panes.contains(pane))
}
