//! Checks which ends of wires fit together, and suggests what to do if they do not.

use super::plan::End;
use crate::document::meaning::Meaning;
use crate::document::{Edit, Path, Pin, Point, Sheet, decor, edit};
use crate::state::{NoEdit, State};
use std::collections::HashSet;
use trochoid::{Accepts, Declaration, Diagnostic, Item, Kind, Role, registry};

/// Reason why a wire cannot be connected.
#[derive(Debug)]
pub(super) struct Refusal {
    /// Connection that was attempted.
    pub(super) title: String,
    /// Reason and remedy.
    pub(super) why: NoWire,
    /// A node that would make the connection possible.
    pub(super) bridge: Option<Bridge>,
}

/// Reason that two ends cannot be connected, in sentences.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoWire {
    #[error("A node cannot use its own output as input.")]
    Itself,
    #[error("{above} already depends on {below}, so the connection would close a cycle.")]
    Cycle { above: String, below: String },
    #[error("\"{0}\" is not a node type, so the kind of its output is unknown.")]
    UnknownType(String),
    #[error("The output is a {kind}; the pin accepts a {accepts}.\n{}.", sentence(&accepts.remedy(*kind)))]
    Kind { kind: Kind, accepts: Accepts },
    #[error(transparent)]
    Edit(#[from] NoEdit),
    /// The connection would give the lower node this fault.
    #[error("Found {}; expected {}.\n{}", .0.found, .0.expected, sentence(&.0.remedy))]
    Fault(Diagnostic),
}

/// A node to insert between two others.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bridge {
    /// Its type.
    pub(super) ty: &'static str,
    /// Edit that inserts it.
    pub(super) edit: Edit,
    /// Its name.
    pub(super) name: String,
}

/// Returns whether a pin accepts a kind, as far as the kind is known.
pub(super) fn takes(accepts: Accepts, kind: Kind) -> bool {
    let image = !matches!(accepts, Accepts::Surface | Accepts::Camera | Accepts::Light | Accepts::View);
    if kind == Kind::ANY { image } else { accepts.takes(kind) }
}

/// Returns whether a pin accepts a kind, as far as the kind is known.
fn admits(pin: &Pin, kind: Kind) -> bool {
    pin.takes_all || takes(pin.accepts, kind)
}

/// Returns the kind of an output; `None` if the node's type is unknown.
pub(super) fn kind(sheet: &Sheet, from: (usize, usize)) -> Option<Kind> {
    sheet.nodes[from.0].makes.get(from.1)?.1
}

/// Returns the nodes to which a wire from this end would close a cycle.
pub(super) fn barred(sheet: &Sheet, held: End) -> HashSet<usize> {
    match held {
        End::Output(node, _) => sheet.upstream([node]),
        End::Pin(node, _) => sheet.downstream([node]),
    }
}

/// Returns whether a wire between two ends would be valid, judging by kinds and cycles alone.
pub(super) fn fits(sheet: &Sheet, held: End, other: End, barred: &HashSet<usize>) -> bool {
    let (from, to) = match (held, other) {
        (End::Output(node, output), End::Pin(below, pin)) => ((node, output), (below, pin)),
        (End::Pin(below, pin), End::Output(node, output)) => ((node, output), (below, pin)),
        _ => return false,
    };
    let pin = &sheet.nodes[to.0].pins[to.1];
    !barred.contains(&other.node()) && kind(sheet, from).is_some_and(|kind| admits(pin, kind))
}

/// Returns the end of a node where the dragged wire would go: preferably one that fits, and of those one that is free.
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

/// Connects an output to a pin. `old` is the pin from which the wire was taken; an inserted bridge node would be placed
/// `at`.
///
/// # Errors
/// The graph would become invalid.
pub(super) fn connect(
    state: &State,
    from: (usize, usize),
    to: (usize, usize),
    old: Option<(usize, usize)>,
    at: Point,
) -> Result<Edit, Box<Refusal>> {
    let sheet = state.sheet();
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
    if !admits(pin, kind) {
        let why = NoWire::Kind { kind, accepts: pin.accepts };
        return refuse(why, bridge(state, from, to, kind, at));
    }
    let mut edit = edit::connected(sheet, from, to);
    if let Some(old) = old.filter(|old| *old != to) {
        edit = edit.then(edit::disconnected(sheet, old));
    }
    match new_fault(state, &edit, &below.name) {
        Some(why) => {
            // While the document is invalid, the kind of an output is only a guess.
            let declared = above.declaration.and_then(|known| Some(known.outputs.get(from.1)?.kind));
            let guessed = declared == Some(Kind::ANY) && !pin.accepts.takes(Kind::Field(1));
            refuse(why, guessed.then(|| bridge(state, from, to, Kind::Field(1), at)).flatten())
        }
        None => Ok(edit),
    }
}

/// Turns a remedy, which begins in lower case, into a sentence.
fn sentence(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}

fn errors<'m>(state: &State, meaning: &'m Meaning, node: &str) -> Vec<&'m Diagnostic> {
    meaning.errors().filter(|error| state.is_of(error, node)).collect()
}

/// Returns the fault that a change would add to a node, if any.
fn new_fault(state: &State, change: &Edit, node: &str) -> Option<NoWire> {
    let after = match state.after(change) {
        Ok((after, _)) => after,
        Err(error) => return Some(error.into()),
    };
    let (old, new) = (errors(state, state.session.meaning(), node), errors(state, &after, node));
    // A fault that another one hid before is not new.
    if new.len() <= old.len() {
        return None;
    }
    let known = |error: &&&Diagnostic| !old.iter().any(|old| (&old.port, &old.found) == (&error.port, &error.found));
    new.into_iter().find(|error| known(&error)).cloned().map(NoWire::Fault)
}

/// Returns whether a node type could convert a kind to one that is accepted.
fn leads(declaration: &Declaration, kind: Kind, accepts: Accepts) -> bool {
    let first = declaration.items.iter().find_map(|item| match item {
        Item::Port(port) if port.accepts.takes(kind) => Some(port),
        _ => None,
    });
    let made = declaration.outputs.first().map(|output| output.kind);
    first.is_some() && made.is_some_and(|made| made != Kind::ANY && accepts.takes(made))
}

/// Finds a node type that makes a connection valid when inserted.
fn bridge(state: &State, from: (usize, usize), to: (usize, usize), kind: Kind, at: Point) -> Option<Bridge> {
    let accepts = state.sheet().nodes[to.0].pins[to.1].accepts;
    let mut types: Vec<&'static Declaration> =
        registry().iter().map(|ty| ty.declaration()).filter(|ty| leads(ty, kind, accepts)).collect();
    types.sort_by_key(|ty| (ty.role != Some(Role::Threshold), ty.items.len(), ty.name));
    // Each candidate is tried on the whole document.
    types.into_iter().take(6).find_map(|ty| between(state, ty, from, to, kind, at))
}

fn between(
    state: &State,
    ty: &'static Declaration,
    from: (usize, usize),
    to: (usize, usize),
    kind: Kind,
    at: Point,
) -> Option<Bridge> {
    let old = state.sheet();
    let (edit, name) = edit::added(old, ty, at);
    let sheet = state.after(&edit).ok()?.1;
    let node = sheet.find(&name)?;
    let pin = sheet.nodes[node].pins.iter().position(|pin| pin.accepts.takes(kind))?;
    let from = (sheet.find(&old.nodes[from.0].name)?, from.1);
    let to = (sheet.find(&old.nodes[to.0].name)?, to.1);
    let edit = edit.then(edit::connected(&sheet, from, (node, pin))).then(edit::connected(&sheet, (node, 0), to));
    let edit = Edit { label: format!("Insert {}", ty.name), ..edit };
    let (after, _) = state.after(&edit).ok()?;
    let below = &sheet.nodes[to.0].name;
    let worse = errors(state, &after, below).len() > errors(state, state.session.meaning(), below).len();
    (!worse && errors(state, &after, &name).is_empty()).then_some(Bridge { ty: ty.name, edit, name })
}

/// Connection requested for a new node.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NewNodeLink {
    /// Nothing.
    Nothing,
    /// The new node takes this output (node name, output index).
    Takes(String, usize),
    /// The new node feeds this pin (node name, pin index).
    Feeds(String, usize),
    /// The new node takes this output and is inserted above everything that used it.
    Below(String, usize),
}

/// Returns whether a node of this type can be connected as requested.
pub(super) fn suits(sheet: &Sheet, declaration: &Declaration, wanted: &NewNodeLink) -> bool {
    match wanted {
        NewNodeLink::Nothing | NewNodeLink::Below(..) => true,
        NewNodeLink::Takes(name, output) => {
            let kind = sheet.find(name).and_then(|node| kind(sheet, (node, *output)));
            kind.is_some_and(|kind| taken(declaration.items, kind) || converter(declaration, kind).is_some())
        }
        NewNodeLink::Feeds(name, pin) => {
            let pin = sheet.node(name).and_then(|node| node.pins.get(*pin));
            pin.is_some_and(|pin| declaration.outputs.iter().any(|output| admits(pin, output.kind)))
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

/// Returns the standard conversion with which a node type takes a kind that it does not take itself.
fn converter(declaration: &Declaration, kind: Kind) -> Option<&'static Declaration> {
    let ty = registry().iter().map(|ty| ty.declaration()).find(|ty| ty.role == Some(Role::Threshold))?;
    let made = ty.outputs.first()?.kind;
    let fits = |items: &[Item], kind: Kind| kind != Kind::ANY && taken(items, kind);
    (!taken(declaration.items, kind) && fits(ty.items, kind) && fits(declaration.items, made)).then_some(ty)
}

/// Returns the conversion that a new node of this type would get before it.
pub(super) fn conversion(
    sheet: &Sheet,
    declaration: &Declaration,
    wanted: &NewNodeLink,
) -> Option<&'static Declaration> {
    let (NewNodeLink::Takes(name, output) | NewNodeLink::Below(name, output)) = wanted else { return None };
    converter(declaration, kind(sheet, (sheet.find(name)?, *output))?)
}

/// Adds a node and the conversion that it needs to take an output; also returns its name. `None` if it needs none.
fn converted(
    state: &State,
    declaration: &'static Declaration,
    at: Point,
    wanted: &NewNodeLink,
) -> Option<(Edit, String)> {
    let old = state.sheet();
    let ty = conversion(old, declaration, wanted)?;
    let (NewNodeLink::Takes(above, output) | NewNodeLink::Below(above, output)) = wanted else { return None };
    let (first, between) = edit::added(old, ty, at);
    let below = [at[0], at[1] + super::place::HEAD + super::place::PICTURE + 40.0];
    let (second, name) = edit::added(&state.after(&first).ok()?.1, declaration, below);
    let edit = known(state, declaration, first.then(second));
    let sheet = state.after(&edit).ok()?.1;
    let from = (sheet.find(above)?, *output);
    let (between, node) = (sheet.find(&between)?, sheet.find(&name)?);
    let pin = |node: usize, kind: Kind| sheet.nodes[node].pins.iter().position(|pin| takes(pin.accepts, kind));
    let made = sheet.nodes[between].makes.first()?.1?;
    let edit = edit
        .then(edit::connected(&sheet, from, (between, pin(between, kind(&sheet, from)?)?)))
        .then(edit::connected(&sheet, (between, 0), (node, pin(node, made)?)));
    Some((Edit { label: format!("Add {} and {}", ty.name, declaration.name), ..edit }, name))
}

/// Brings the group that an edit uses into the document, if the document does not have it.
fn known(state: &State, declaration: &Declaration, edit: Edit) -> Edit {
    crate::shipped::with_group(state.sheet(), &state.session.folder(), declaration.name, edit)
}

/// Adds a node and connects it as requested, as far as it fits; also returns its name.
pub(super) fn added(
    state: &State,
    declaration: &'static Declaration,
    at: Point,
    wanted: &NewNodeLink,
) -> (Edit, String) {
    if let Some(converted) = converted(state, declaration, at, wanted) {
        return converted;
    }
    let (edit, name) = edit::added(state.sheet(), declaration, at);
    let edit = known(state, declaration, edit);
    let joined = state.after(&edit).ok().and_then(|(_, sheet)| joins(&sheet, &name, wanted));
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
            let taking = sheet.nodes[below].pins.get(*pin)?;
            let output = new.makes.iter().position(|(_, made)| made.is_some_and(|made| admits(taking, made)))?;
            Some(edit::connected(sheet, (node, output), (below, *pin)))
        }
        NewNodeLink::Takes(above, output) | NewNodeLink::Below(above, output) => {
            let from = (sheet.find(above)?, *output);
            let kind = kind(sheet, from)?;
            let pin = new.pins.iter().position(|pin| takes(pin.accepts, kind))?;
            let mut edit = edit::connected(sheet, from, (node, pin));
            // What a scene is made of stands beside what it takes: a boat on a sea does not replace the sea.
            let passes_on = !matches!(kind, Kind::Surface | Kind::Camera | Kind::Light);
            if passes_on && matches!(wanted, NewNodeLink::Below(..)) {
                let made = new.makes.first().and_then(|(_, made)| *made)?;
                let made = if made == Kind::ANY { kind } else { made };
                let below = sheet.wires.iter().filter(|wire| wire.from == from);
                for wire in below.filter(|wire| admits(&sheet.nodes[wire.to.0].pins[wire.to.1], made)) {
                    edit = edit.then(edit::connected(sheet, (node, 0), wire.to));
                }
                edit = edit.then(outputs(sheet, from, name, kind == made));
            }
            Some(edit)
        }
    }
}

/// Moves the outputs that render a node's result to a new node below it.
fn outputs(sheet: &Sheet, from: (usize, usize), name: &str, same: bool) -> Edit {
    let mut ops = Vec::new();
    for output in sheet.outputs.iter().filter(|output| same && sheet.source(&output.source) == Some(from)) {
        let path = Path::default().to("outputs").to(&output.name);
        let keys = ["color", "weights", "field", "recipe"].into_iter().map(|key| path.to(key));
        let key = keys.into_iter().find(|key| sheet.get(key).is_some());
        ops.extend(key.map(|key| crate::document::Op::Set(key, crate::document::json::quoted(name))));
    }
    Edit::new("Redirect outputs", ops)
}
