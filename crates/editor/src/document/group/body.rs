//! Rewriting of a node's references and links.

use super::link;
use crate::document::color::is_color;
use serde_json::Value;
use trochoid::{Arity, Item};

/// What takes the place of a reference.
pub(super) enum Connected {
    /// A reference, a literal, or a list of them.
    To(Value),
    /// Nothing: the port stays open.
    Open,
}

/// Rewrites what a node refers to.
pub(super) struct Rewriter<'r, E> {
    /// Returns what takes the place of a reference.
    pub(super) reference: &'r mut dyn FnMut(&str) -> Result<Connected, E>,
    /// Returns what takes the place of a link.
    pub(super) link: &'r mut dyn FnMut(&str) -> Result<Value, E>,
}

impl<E> Rewriter<'_, E> {
    /// Rewrites the items of a node or of a record.
    pub(super) fn items(&mut self, items: &[Item], body: &mut Value) -> Result<(), E> {
        let Some(entries) = body.as_object_mut() else { return Ok(()) };
        for item in items {
            let Some(value) = entries.get_mut(item.name()) else { continue };
            let stays = match item {
                Item::Knob(_) => {
                    self.links(value)?;
                    true
                }
                Item::Port(port) => self.port(matches!(port.arity, Arity::Many { .. }), value)?,
                Item::List(list) => {
                    let records = value.as_array_mut().map_or(&mut [][..], |records| &mut records[..]);
                    records.iter_mut().try_for_each(|record| self.items(list.items, record))?;
                    true
                }
            };
            if !stays {
                entries.shift_remove(item.name());
            }
        }
        Ok(())
    }

    /// Rewrites the value of a port; returns whether something is connected afterwards.
    fn port(&mut self, is_list: bool, value: &mut Value) -> Result<bool, E> {
        match value {
            Value::String(text) if !link::is_link(text) && !is_color(text) => match (self.reference)(text)? {
                Connected::To(new) => *value = new,
                Connected::Open => return Ok(false),
            },
            Value::Array(elements) if is_list => {
                let mut all = Vec::new();
                for mut element in std::mem::take(elements) {
                    let was_reference = element.is_string();
                    if !self.port(false, &mut element)? {
                        continue;
                    }
                    match element {
                        // An input may have several connections.
                        Value::Array(several) if was_reference => all.extend(several),
                        one => all.push(one),
                    }
                }
                *elements = all;
            }
            other => self.links(other)?,
        }
        Ok(true)
    }

    /// Rewrites all links in a value.
    pub(super) fn links(&mut self, value: &mut Value) -> Result<(), E> {
        match value {
            Value::String(text) if link::is_link(text) => *value = (self.link)(text)?,
            Value::Array(items) => items.iter_mut().try_for_each(|item| self.links(item))?,
            Value::Object(entries) => {
                for (_, value) in entries.iter_mut().filter(|(key, _)| !link::is_remark(key)) {
                    self.links(value)?;
                }
            }
            _ => {}
        }
        Ok(())
    }
}
