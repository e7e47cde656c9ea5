//! Which ends of wires fit together, and what to do where they do not.

use super::plan::End;
use crate::document::json::Misplaced;
use crate::document::meaning::Meaning;
use crate::document::{Edit, Path, Point, Session, Sheet, decor, edit};
use std::collections::HashSet;
use trochoid::{Accepts, Declaration, Diagnostic, Item, Kind, Role, registry};

/// Why a wire is not drawn.
#[derive(Debug)]
pub(super) struct Refusal {
    /// What was to be connected.
    pub(super) title: String,
    /// Why it cannot be, and what to do.
    pub(super) why: NoWire,
    /// A node that makes it possible.
    pub(super) bridge: Option<Bridge>,
}

/// Why two ends cannot be connected, in sentences.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoWire {
    #[error("A node cannot take what it makes.")]
    Itself,
    #[error("{above} depends on {below} already: a graph has no cycles.")]
    Cycle { above: String, below: String },
    #[error("\"{0}\" is no type of node, so nothing is known of what it makes.")]
    UnknownType(String),
    #[error("It makes a {kind}; the pin takes a {accepts}.\n{}.", sentence(&accepts.remedy(*kind)))]
    Kind { kind: Kind, accepts: Accepts },
    #[error(transparent)]
    Misplaced(#[from] Misplaced),
    /// The node below would have this fault.
    #[error("Found {}; expected {}.\n{}", .0.found, .0.expected, sentence(&.0.remedy))]
    Fault(Diagnostic),
}

/// A node between two others.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bridge {
    /// Its type.
    pub(super) ty: &'static str,
    /// What puts it there.
    pub(super) edit: Edit,
    /// Its name.
    pub(super) name: String,
}

/// Whether a pin takes a kind, as far as it is known.
pub(super) fn takes(accepts: Accepts, kind: Kind) -> bool {
    let image = !matches!(accepts, Accepts::Surface | Accepts::Camera | Accepts::Light | Accepts::View);
    if kind == Kind::ANY { image } else { accepts.takes(kind) }
}

/// The kind that an output makes; none where the type is not known.
pub(super) fn kind(sheet: &Sheet, from: (usize, usize)) -> Option<Kind> {
    sheet.nodes[from.0].makes.get(from.1)?.1
}

/// Nodes to which a wire from this end would close a cycle.
pub(super) fn barred(sheet: &Sheet, held: End) -> HashSet<usize> {
    match held {
        End::Output(node, _) => sheet.upstream([node]),
        End::Pin(node, _) => sheet.downstream([node]),
    }
}

/// Whether a wire between two ends would be legal, as far as kinds tell.
pub(super) fn fits(sheet: &Sheet, held: End, other: End, barred: &HashSet<usize>) -> bool {
    let (from, to) = match (held, other) {
        (End::Output(node, output), End::Pin(below, pin)) => ((node, output), (below, pin)),
        (End::Pin(below, pin), End::Output(node, output)) => ((node, output), (below, pin)),
        _ => return false,
    };
    let accepts = sheet.nodes[to.0].pins[to.1].accepts;
    !barred.contains(&other.node()) && kind(sheet, from).is_some_and(|kind| takes(accepts, kind))
}

/// The end of a node at which a wire that is held would go: one that fits, rather one that is free.
pub(super) fn best_end(sheet: &Sheet, held: End, node: usize, barred: &HashSet<usize>) -> Option<End> {
    match held {
        End::Output(..) => {
            let pins = || (0..sheet.nodes[node].pins.len()).map(|pin| End::Pin(node, pin));
            let is_free = |end: &End| {
                let End::Pin(_, pin) = *end else { return false };
                !sheet.wires.iter().any(|wire| wire.to == (node, pin))
            };
            let fitting = || pins().filter(|end| fits(sheet, held, *end, barred));
            fitting().find(is_free).or_else(|| fitting().next()).or_else(|| pins().next())
        }
        End::Pin(..) => {
            let outputs = || (0..sheet.nodes[node].makes.len()).map(|output| End::Output(node, output));
            outputs().find(|end| fits(sheet, held, *end, barred)).or_else(|| outputs().next())
        }
    }
}

/// Connects an output to a pin; `old` is the pin from which the wire is taken, and a node between would stand `at`.
///
/// # Errors
/// The graph would not be legal.
pub(super) fn connect(
    session: &Session,
    from: (usize, usize),
    to: (usize, usize),
    old: Option<(usize, usize)>,
    at: Point,
) -> Result<Edit, Box<Refusal>> {
    let sheet = session.sheet();
    let (above, below) = (&sheet.nodes[from.0], &sheet.nodes[to.0]);
    let pin = &below.pins[to.1];
    let source = sheet.reference(from.0, from.1);
    let title = format!("{source} cannot go to {}", decor::key(sheet, to));
    let refuse = |why: NoWire, bridge: Option<Bridge>| Err(Box::new(Refusal { title: title.clone(), why, bridge }));
    if sheet.upstream([from.0]).contains(&to.0) {
        let why = match from.0 == to.0 {
            true => NoWire::Itself,
            false => NoWire::Cycle { above: above.name.clone(), below: below.name.clone() },
        };
        return refuse(why, None);
    }
    let Some(kind) = kind(sheet, from) else {
        return refuse(NoWire::UnknownType(above.ty.clone()), None);
    };
    if !takes(pin.accepts, kind) {
        let why = NoWire::Kind { kind, accepts: pin.accepts };
        return refuse(why, bridge(session, from, to, kind, at));
    }
    let mut edit = edit::connected(sheet, from, to);
    if let Some(old) = old.filter(|old| *old != to) {
        edit = edit.then(edit::disconnected(sheet, old));
    }
    match new_fault(session, &edit, &below.name) {
        Some(why) => {
            // What a node hands on is guessed as long as the document is not valid.
            let declared = above.declaration.and_then(|known| Some(known.outputs.get(from.1)?.kind));
            let guessed = declared == Some(Kind::ANY) && !pin.accepts.takes(Kind::Field(1));
            refuse(why, guessed.then(|| bridge(session, from, to, Kind::Field(1), at)).flatten())
        }
        None => Ok(edit),
    }
}

/// A sentence from a remedy, which begins small.
fn sentence(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}

fn errors<'m>(meaning: &'m Meaning, node: &str) -> Vec<&'m Diagnostic> {
    meaning.errors().filter(|error| error.node.as_deref() == Some(node)).collect()
}

/// What a change would make wrong about a node that is not wrong already.
fn new_fault(session: &Session, change: &Edit, node: &str) -> Option<NoWire> {
    let after = match session.after(change) {
        Ok(after) => after,
        Err(error) => return Some(error.into()),
    };
    let (old, new) = (errors(session.meaning(), node), errors(&after, node));
    // What was hidden behind another fault is no new one.
    if new.len() <= old.len() {
        return None;
    }
    let known = |error: &&&Diagnostic| !old.iter().any(|old| (&old.port, &old.found) == (&error.port, &error.found));
    new.into_iter().find(|error| known(&error)).cloned().map(NoWire::Fault)
}

/// Whether a node type could stand between what makes a kind and what takes something else.
fn leads(declaration: &Declaration, kind: Kind, accepts: Accepts) -> bool {
    let first = declaration.items.iter().find_map(|item| match item {
        Item::Port(port) if port.accepts.takes(kind) => Some(port),
        _ => None,
    });
    let made = declaration.outputs.first().map(|output| output.kind);
    first.is_some() && made.is_some_and(|made| made != Kind::ANY && accepts.takes(made))
}

/// One node that makes a connection legal, if there is any.
fn bridge(session: &Session, from: (usize, usize), to: (usize, usize), kind: Kind, at: Point) -> Option<Bridge> {
    let accepts = session.sheet().nodes[to.0].pins[to.1].accepts;
    let mut types: Vec<&'static Declaration> =
        registry().iter().map(|ty| ty.declaration()).filter(|ty| leads(ty, kind, accepts)).collect();
    types.sort_by_key(|ty| (ty.role != Some(Role::Threshold), ty.items.len(), ty.name));
    // Each is tried on the whole document.
    types.into_iter().take(6).find_map(|ty| between(session, ty, from, to, kind, at))
}

fn between(
    session: &Session,
    ty: &'static Declaration,
    from: (usize, usize),
    to: (usize, usize),
    kind: Kind,
    at: Point,
) -> Option<Bridge> {
    let old = session.sheet();
    let (edit, name) = edit::added(old, ty, at);
    let sheet = session.after(&edit).ok()?.sheet;
    let node = sheet.find(&name)?;
    let pin = sheet.nodes[node].pins.iter().position(|pin| pin.accepts.takes(kind))?;
    let from = (sheet.find(&old.nodes[from.0].name)?, from.1);
    let to = (sheet.find(&old.nodes[to.0].name)?, to.1);
    let edit = edit.then(edit::connected(&sheet, from, (node, pin))).then(edit::connected(&sheet, (node, 0), to));
    let edit = Edit { label: format!("Put a {} between", ty.name), ..edit };
    let after = session.after(&edit).ok()?;
    let below = &sheet.nodes[to.0].name;
    let worse = errors(&after, below).len() > errors(session.meaning(), below).len();
    (!worse && errors(&after, &name).is_empty()).then_some(Bridge { ty: ty.name, edit, name })
}

/// What a new node is joined to.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NewNodeLink {
    /// Nothing.
    Nothing,
    /// It takes an output, by the name of its node.
    Takes(String, usize),
    /// What it makes goes to this pin.
    Feeds(String, usize),
    /// It takes an output, and all that took that takes the new node's instead.
    Below(String, usize),
}

/// Whether a node of a type can be joined as it is wanted.
pub(super) fn suits(sheet: &Sheet, declaration: &Declaration, wanted: &NewNodeLink) -> bool {
    match wanted {
        NewNodeLink::Nothing | NewNodeLink::Below(..) => true,
        NewNodeLink::Takes(name, output) => {
            let kind = sheet.find(name).and_then(|node| kind(sheet, (node, *output)));
            kind.is_some_and(|kind| taken(declaration.items, kind))
        }
        NewNodeLink::Feeds(name, pin) => {
            let pin = sheet.node(name).and_then(|node| node.pins.get(*pin));
            pin.is_some_and(|pin| declaration.outputs.iter().any(|output| takes(pin.accepts, output.kind)))
        }
    }
}

fn taken(items: &[Item], kind: Kind) -> bool {
    items.iter().any(|item| match item {
        Item::Port(port) => takes(port.accepts, kind),
        Item::Knob(_) => false,
        Item::List(list) => list.min > 0 && taken(list.items, kind),
    })
}

/// Adds a node and joins it as it is wanted, as far as that fits; also its name.
pub(super) fn added(
    session: &Session,
    declaration: &'static Declaration,
    at: Point,
    wanted: &NewNodeLink,
) -> (Edit, String) {
    let (edit, name) = edit::added(session.sheet(), declaration, at);
    let joined = session.after(&edit).ok().and_then(|after| joins(&after.sheet, &name, wanted));
    match joined {
        Some(joined) => (Edit { label: edit.label.clone(), ..edit.then(joined) }, name),
        None => (edit, name),
    }
}

fn joins(sheet: &Sheet, name: &str, wanted: &NewNodeLink) -> Option<Edit> {
    let node = sheet.find(name)?;
    let new = &sheet.nodes[node];
    match wanted {
        NewNodeLink::Nothing => None,
        NewNodeLink::Feeds(below, pin) => {
            let below = sheet.find(below)?;
            let accepts = sheet.nodes[below].pins.get(*pin)?.accepts;
            let output = new.makes.iter().position(|(_, made)| made.is_some_and(|made| takes(accepts, made)))?;
            Some(edit::connected(sheet, (node, output), (below, *pin)))
        }
        NewNodeLink::Takes(above, output) | NewNodeLink::Below(above, output) => {
            let from = (sheet.find(above)?, *output);
            let kind = kind(sheet, from)?;
            let pin = new.pins.iter().position(|pin| takes(pin.accepts, kind))?;
            let mut edit = edit::connected(sheet, from, (node, pin));
            if matches!(wanted, NewNodeLink::Below(..)) {
                let made = new.makes.first().and_then(|(_, made)| *made)?;
                let made = if made == Kind::ANY { kind } else { made };
                let below = sheet.wires.iter().filter(|wire| wire.from == from);
                for wire in below.filter(|wire| takes(sheet.nodes[wire.to.0].pins[wire.to.1].accepts, made)) {
                    edit = edit.then(edit::connected(sheet, (node, 0), wire.to));
                }
                edit = edit.then(outputs(sheet, from, name, kind == made));
            }
            Some(edit)
        }
    }
}

/// Lets what is rendered of an output be rendered of a new node below it.
fn outputs(sheet: &Sheet, from: (usize, usize), name: &str, same: bool) -> Edit {
    let mut ops = Vec::new();
    for output in sheet.outputs.iter().filter(|output| same && sheet.source(&output.source) == Some(from)) {
        let path = Path::default().to("outputs").to(&output.name);
        let keys = ["color", "weights", "field"].into_iter().map(|key| path.to(key));
        let key = keys.into_iter().find(|key| sheet.get(key).is_some());
        ops.extend(key.map(|key| crate::document::Op::Set(key, crate::document::json::quoted(name))));
    }
    Edit::new("Lead outputs", ops)
}
