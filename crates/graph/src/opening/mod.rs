//! Inputs: the nodes, and the literals that become nodes, for which a program supplies samples.

mod faults;
mod nodes;

use crate::*;
use nodes::{COLOR, MASK, NUMBER};

/// What a literal becomes.
type Made = (&'static NodeType, Animated, Kind);

impl CheckedGraph {
    /// Returns the node of a name for which a program can supply samples. A color of the palette, `palette.NAME`, a knob of
    /// the document, `knobs.NAME`, or a literal at a port, such as `paint.a` or `water.stops[1].color`, becomes a node of
    /// that name; as long as nobody supplies samples, the pictures stay the same.
    ///
    /// # Errors
    /// There is no such node or literal, its value is no image, or the color or knob is also used where nothing can be
    /// connected: in a knob of a node, in a formula, or between keys. Then the graph stays as it was. The fault has a place
    /// if the document has one.
    pub fn open(&mut self, name: &str) -> Result<NodeId, Box<Diagnostic>> {
        if let Some(id) = self.find(name) {
            return match self.node(id).kinds.first() {
                Some(Kind::Color | Kind::Weights(_) | Kind::Field(_)) => Ok(id),
                _ => Err(self.no_image(id)),
            };
        }
        let places = self.places_called(name)?;
        let mut made: Option<Made> = None;
        for (node, item) in &places {
            let now = self.literal_at(name, *node, item)?;
            // A number that is a weight somewhere is one everywhere.
            if made.is_none() || now.2 == Kind::MASK {
                made = Some(now);
            }
        }
        let (Some((ty, value, kind)), Some((first, _))) = (made, places.first()) else {
            return Err(self.unused(name));
        };
        let place = self.nodes[first.0].place.clone();
        let opened = NodeId(self.nodes.len());
        for (node, item) in &places {
            if let Some(source) = source_at(&mut self.nodes[node.0].record, item) {
                *source = Source::Output { node: opened, output: 0 };
            }
        }
        self.nodes.push(CheckedNode {
            name: name.into(),
            ty,
            record: Record { knobs: vec![("value", Setting::Numeric(value))], ..Record::default() },
            kinds: vec![kind],
            disabled: false,
            place,
            places: Vec::new(),
        });
        self.order.insert(0, opened);
        Ok(opened)
    }

    /// Returns the ports whose literals a name means.
    fn places_called(&self, name: &str) -> Result<Vec<(NodeId, String)>, Box<Diagnostic>> {
        let Some((first, item)) = name.split_once('.') else { return Err(self.no_such_input(name)) };
        match first {
            "palette" => {
                let color = self.palette.iter().find(|color| color.name == item);
                let color = color.ok_or_else(|| self.no_such_input(name))?;
                match color.uses.iter().find(|place| !place.is_whole) {
                    Some(within) => Err(self.within_value(name, within)),
                    None => Ok(color.uses.iter().map(|place| (place.node, place.item.clone())).collect()),
                }
            }
            "knobs" => {
                let knob = self.knobs.iter().find(|knob| knob.name == item);
                let knob = knob.ok_or_else(|| self.no_such_input(name))?;
                if knob.is_used && !knob.is_whole {
                    return Err(self.computed_with(name, knob));
                }
                Ok(knob.ports.clone())
            }
            _ => match self.find(first) {
                Some(node) => Ok(vec![(node, item.into())]),
                None => Err(self.no_such_input(name)),
            },
        }
    }

    /// Returns what the literal of a port becomes.
    fn literal_at(&mut self, name: &str, node: NodeId, item: &str) -> Result<Made, Box<Diagnostic>> {
        let accepts = match item_at(self.nodes[node.0].ty.declaration().items, item) {
            At::Port(accepts) => Some(accepts),
            At::Knob | At::List | At::Nothing => None,
        };
        let source = accepts.and_then(|_| source_at(&mut self.nodes[node.0].record, item));
        match source {
            Some(Source::Color(color)) => Ok((&COLOR, color.clone(), Kind::Color)),
            Some(Source::Number(number)) if matches!(accepts, Some(Accepts::Mask | Accepts::Image)) => {
                Ok((&MASK, number.clone(), Kind::MASK))
            }
            Some(Source::Number(number)) => Ok((&NUMBER, number.clone(), Kind::Field(1))),
            other => {
                let other = other.map(|source| source.clone());
                Err(self.no_literal(name, node, item, other.as_ref()))
            }
        }
    }
}

/// What is declared at a path such as `stops[1].color`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum At {
    Port(Accepts),
    Knob,
    List,
    Nothing,
}

fn item_at(items: &'static [Item], path: &str) -> At {
    let (step, rest) = path.split_once('.').map_or((path, None), |(step, rest)| (step, Some(rest)));
    let Some((name, _)) = step_of(step) else { return At::Nothing };
    let found = items.iter().find_map(|item| match (item, rest) {
        (Item::Port(port), None) if port.name == name => Some(At::Port(port.accepts)),
        (Item::Knob(knob), _) if knob.name == name => Some(At::Knob),
        (Item::List(list), None) if list.name == name => Some(At::List),
        (Item::List(list), Some(rest)) if list.name == name => Some(item_at(list.items, rest)),
        _ => None,
    });
    found.unwrap_or(At::Nothing)
}

/// Returns the source at a path.
fn source_at<'r>(record: &'r mut Record, path: &str) -> Option<&'r mut Source> {
    let (step, rest) = path.split_once('.').map_or((path, None), |(step, rest)| (step, Some(rest)));
    let (name, index) = step_of(step)?;
    match rest {
        None => {
            let (_, sources) = record.ports.iter_mut().find(|(known, _)| *known == name)?;
            sources.get_mut(index)
        }
        Some(rest) => {
            let (_, records) = record.lists.iter_mut().find(|(known, _)| *known == name)?;
            source_at(records.get_mut(index)?, rest)
        }
    }
}

/// Splits `stops[1]` into the name and the index, which is 0 if there is none.
fn step_of(step: &str) -> Option<(&str, usize)> {
    match step.split_once('[') {
        Some((name, index)) => Some((name, index.strip_suffix(']')?.parse().ok()?)),
        None => Some((step, 0)),
    }
}
