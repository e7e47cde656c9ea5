//! The node types that a document may use.

use crate::{Formulas, Item, NodeType, Role};
use std::collections::BTreeMap;

/// Node types by name. The facade makes one registry and passes it to everything that needs it.
#[derive(Clone, Default)]
pub struct Registry {
    types: BTreeMap<&'static str, &'static NodeType>,
    formulas: Option<&'static dyn Formulas>,
}

impl Registry {
    /// Makes a registry of node types; of two types with the same name, the later one counts.
    pub fn new(types: impl IntoIterator<Item = &'static NodeType>) -> Self {
        Self { types: types.into_iter().map(|ty| (ty.declaration().name, ty)).collect(), formulas: None }
    }

    /// Returns the registry with a parser of formulas, without which links take only values as they are.
    #[must_use]
    pub fn with_formulas(self, formulas: &'static dyn Formulas) -> Self {
        Self { formulas: Some(formulas), ..self }
    }

    /// Returns a registry with another type beside those of this one, whose type of the same name it replaces.
    #[must_use]
    pub fn with(&self, ty: &'static NodeType) -> Self {
        let mut types = self.types.clone();
        types.insert(ty.declaration().name, ty);
        Self { types, formulas: self.formulas }
    }

    /// Returns the parser of formulas.
    pub fn formulas(&self) -> Option<&'static dyn Formulas> {
        self.formulas
    }

    /// Returns the type with a name.
    pub fn get(&self, name: &str) -> Option<&'static NodeType> {
        self.types.get(name).copied()
    }

    /// Returns the type with a role.
    pub fn of_role(&self, role: Role) -> Option<&'static NodeType> {
        self.iter().find(|ty| ty.declaration().role == Some(role))
    }

    /// Returns all types, sorted by name.
    pub fn iter(&self) -> impl Iterator<Item = &'static NodeType> {
        self.types.values().copied()
    }

    /// Returns all names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.types.keys().copied()
    }
}

impl std::fmt::Debug for Registry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(self.types.keys()).finish()
    }
}

/// Returns the names of the items of a declaration, in order.
pub(crate) fn item_names(items: &'static [Item]) -> impl Iterator<Item = &'static str> {
    items.iter().map(Item::name)
}
